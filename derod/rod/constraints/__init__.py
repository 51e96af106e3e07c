"""The constraints, one a file: lengths, menisci on the sphere, the drop's place along the rod.

Each offers ``add_gradient`` and ``add_hessian`` of multiplier times constraint, with the terms'
arguments; where its multipliers sit, and how many negative eigenvalues it brings, is told in
``rod.unknowns``.
"""
