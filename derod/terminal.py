"""What derod writes to a terminal: results, and remarks.

Results go to standard output, and results that cannot be shown are an error. Remarks go to standard error,
and nobody who reads them, or stops reading them, can end or fail what they are about. Both are printed with
control characters written out.
"""

from __future__ import annotations

import contextlib
import errno
import os
import sys

from derod.errors import DerodError, printable

MOST_LINE = 100_000
"""Characters of a line of results: they are ours, only names in them are somebody else's."""


class NotShownError(DerodError):
    """Results that could not be printed."""


def keep_descriptors() -> None:
    """Open the null device where standard input, output or error is closed.

    Otherwise the next file that is opened, a run, would take its place and be written into.
    """
    while True:
        descriptor = os.open(os.devnull, os.O_RDWR)
        if descriptor > 2:
            os.close(descriptor)
            break
    if sys.stderr is None:
        sys.stderr = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115, PTH123  for good


def say(text: str) -> None:
    """Print a remark to standard error, if anybody is there."""
    if sys.stderr is None:  # closed, in a process that is not ours
        return
    with contextlib.suppress(OSError, ValueError):
        print(printable(text), file=sys.stderr, flush=True)


def show(text: str) -> None:
    """Print results, line by line, to standard output; raises NotShownError."""
    if sys.stdout is None:
        raise NotShownError("the results cannot be shown: standard output is closed")
    try:
        for line in text.split("\n"):
            _write(_encodable(printable(line, MOST_LINE)) + "\n")
    except (OSError, ValueError) as error:
        raise _not_shown(error) from error


def _write(line: str) -> None:
    """Write to standard output; an unbuffered one does not say by itself that it took nothing."""
    under = getattr(sys.stdout, "buffer", None)
    if under is None:
        sys.stdout.write(line)
        return
    sys.stdout.flush()
    data = line.encode(sys.stdout.encoding, "backslashreplace")
    while data:
        taken = under.write(data)
        if not taken:
            raise BlockingIOError(errno.EAGAIN, os.strerror(errno.EAGAIN))
        data = data[taken:]


def say_done(text: str) -> None:
    """Print to standard output what a finished file says as well: nobody has to read it."""
    with contextlib.suppress(NotShownError):
        show(text)
        finish()


def finish() -> None:
    """Hand over all that was shown; raises NotShownError."""
    if sys.stdout is None:
        return
    try:
        sys.stdout.flush()
    except (OSError, ValueError) as error:
        raise _not_shown(error) from error


def silence() -> None:
    """Send what is left of the output nowhere, so that Python's own last flush finds a reader."""
    with contextlib.suppress(OSError, ValueError, AttributeError):
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, sys.stdout.fileno())
        os.close(nowhere)


def _encodable(line: str) -> str:
    """The line in what standard output can be written in."""
    encoding = getattr(sys.stdout, "encoding", None) or "utf-8"
    return line.encode(encoding, "backslashreplace").decode(encoding)


def _not_shown(error: Exception) -> NotShownError:
    silence()
    reason = error.strerror.lower() if isinstance(error, OSError) and error.strerror else str(error)
    return NotShownError(f"the results cannot be shown: {reason}")
