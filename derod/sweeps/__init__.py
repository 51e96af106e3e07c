"""Many pushes: a scene, the keys that vary, and one table of what came out.

``plan`` <- ``spreads``, ``sampling``: what is varied and which points that makes. ``points``: one point
pushed. ``engines``: points pushed here or by Dask. ``journal``: finished points on the disk. ``files``: the
combined table. ``running``: all of it put together.
"""
