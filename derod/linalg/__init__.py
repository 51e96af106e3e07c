"""Linear algebra of the bordered band: factor, solve, count negative eigenvalues."""
