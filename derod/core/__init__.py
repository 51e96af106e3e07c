"""Numba kernels of the discrete elastic rod in a drop: floats and arrays only, no objects.

A kernel never sees a scene. It sees a state (``q``, ``b``), constants (``Physics``, ``Mesh``) and
arrays to fill. Every physical term lives in one file and offers the same few functions, in the
paper's symbols; ``assembly`` is the only place that names them all.
"""

from derod._cache import point_numba_at_own_cache

point_numba_at_own_cache()
