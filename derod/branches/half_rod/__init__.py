"""The half-rod problem: its parameters and equations, their discretisation, and what a state is.

The rod's half s in [0, l/2] in the drop's frame, collocated and eliminated to 37 unknowns and 14
conditions, in mirror classes; energies, meshes, symmetries and the second variation of a state.
Nothing here knows of paths or files.
"""
