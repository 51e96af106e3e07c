"""What the exit codes of the command line mean, and the error of its arguments."""

from __future__ import annotations

from derod.errors import DerodError

DONE, BAD_INPUT, NOT_REACHED, INTERRUPTED = 0, 2, 3, 130


class UsageError(DerodError):
    """Arguments that make no sense together, or with the files that are there."""
