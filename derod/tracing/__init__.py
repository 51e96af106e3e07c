"""Equilibria of the discrete rod followed by pseudo-arclength, stable or not, symmetric or not.

bordered     the Hessian with one border row more: regular at folds
arc          the metric of a path, its points, and the step from one to the next
critical     the eigenvalues nearest zero
special      folds, branch points and joints, located between two points
path         a path from its first point to its end
switching    onto the branches that meet at a branch point; the straight rod's buckling points
symmetry     images of a state under the symmetries of its scene, and duplicates
"""
