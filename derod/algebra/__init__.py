"""Ground floor: how kernels are compiled and cached, and the bordered band matrix."""

from derod.algebra.cache import point_numba_at_own_cache

point_numba_at_own_cache()
