"""What Dask's local workers do when they begin (Dask imports this module in each)."""

from __future__ import annotations

import signal


def dask_setup(worker: object) -> None:
    """Leave Ctrl-C, which a terminal sends to all processes, to the sweep: it ends its workers."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
