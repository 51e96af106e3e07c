"""What the exit codes of the command line mean, and the error of its arguments."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager

from derod.errors import DerodError

DONE, EXCEEDED, BAD_INPUT, NOT_REACHED, NOT_SHOWN, INTERRUPTED = 0, 1, 2, 3, 4, 130
MEANINGS = (
    "Exit codes: 0 done (push: reached the stop), 1 compare: an error exceeds the tolerance, 2 bad input or "
    "a file that must not be written, 3 not reached, not found or not recorded, 4 done, but the results "
    "could not be printed, 128 + n ended by signal n (130: Ctrl-C)."
)


class UsageError(DerodError):
    """Arguments that make no sense together, or with the files that are there."""


@contextmanager
def naming_options(*names: str) -> Iterator[None]:
    """Let complaints of the Python functions about their arguments name the command line's options."""
    try:
        yield
    except UsageError as error:
        told = re.sub(rf"(^|: )({'|'.join(names)}) = ", r"\1--\2 = ", str(error), count=1)
        raise UsageError(told) from error
