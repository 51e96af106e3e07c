"""Values of a scene from measured curves of force against displacement.

``data``: the measured table. ``model``: what a scene says of it, and its derivatives. ``solving``: least
squares, covariance, what the data do not determine. ``writing``: the result as files.
"""
