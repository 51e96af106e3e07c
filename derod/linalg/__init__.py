"""Linear algebra of the bordered band: factor, solve, count negative eigenvalues."""

from derod._cache import point_numba_at_own_cache

point_numba_at_own_cache()
