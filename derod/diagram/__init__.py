"""Diagram files: paths of equilibria, what is known of their special points, and how they hang together.

layout     what is in a file
content    a diagram in memory, made of traced paths or read from a file
writing    a file made anew, in one step
reading    a file read, held against its checksums
restoring  a diagram's paths made ready to go on with
"""
