"""Files of ours and of strangers: HDF5 read in bounded time and memory and held against checksums, locks,
and outputs that appear in one step. Runs and branches share this, and nothing else.
"""
