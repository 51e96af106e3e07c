"""Solution paths of the half-rod problem: followed, named, and landed on.

Newton's method, pseudo-arclength steps, folds and pitchforks, the paper's paths by name, heavy
drops, counts of unstable modes, mesh errors, and states at a given end-shortening. Uses the
half rod; knows of no files.
"""
