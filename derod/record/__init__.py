"""The record of a push: one HDF5 file, or a run in memory."""

from derod.record.attach import attach_extrapolated
from derod.record.memory import MemoryRun
from derod.record.reader import Run, open_run
from derod.record.run import BaseRun
from derod.record.writer import RunWriter, locked, resume_copy

__all__ = [
    "BaseRun",
    "MemoryRun",
    "Run",
    "RunWriter",
    "attach_extrapolated",
    "locked",
    "open_run",
    "resume_copy",
]
