"""The discrete elastic rod in a drop: its unknowns, its terms, their sums and derivatives.

A kernel never sees a scene. It sees a state (``q``, ``b``), constants (``Physics``, ``Mesh``) and
arrays to fill. Every physical term lives in one file and offers the same few functions, in the
paper's symbols; ``assembly`` is the only place that names them all.
"""
