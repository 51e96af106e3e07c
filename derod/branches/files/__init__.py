"""Branch files and what is made of them: written, read, checked, exported, compared with runs.

The commands ``derod branch`` and ``derod compare`` are here too. Uses the half rod and its paths.
"""
