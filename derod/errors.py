"""The errors derod raises on purpose: what the user can act on, said in one line."""

from __future__ import annotations

SHOWN_CHARACTERS = 60
LINE_CHARACTERS = 1000


class DerodError(Exception):
    """Base of every error that derod raises on purpose.

    ``str(error)`` is one line that a terminal can show: see ``printable``.
    """

    def __init__(self, message: object = "") -> None:
        super().__init__(printable(str(message)))


class SceneError(DerodError):
    """A scene that cannot be simulated.

    ``str(error)`` is one line that names the file, the key, the value and what is allowed; the same
    four are kept as attributes (None where they have no meaning, e.g. for broken TOML). ``written``
    is the value as the line shall show it.
    """

    def __init__(
        self,
        problem: str,
        *,
        file: object = None,
        key: str | None = None,
        value: object = None,
        allowed: str | None = None,
        written: str | None = None,
    ) -> None:
        self.problem = problem
        self.file = None if file is None else str(file)
        self.key = key
        self.value = value
        self.allowed = allowed
        where = "scene" if self.file is None else self.file
        line = f"{where}:"
        if key is not None:
            line += f" {shown_name(key)}"
        if value is not None:
            line += f" = {written or shown(value)}"
        line += f" {problem}"
        if allowed is not None:
            line += f"; allowed: {allowed}"
        super().__init__(" ".join(line.split()))  # the ends of TOML's lines are spaces here


class RecordError(DerodError):
    """A run file that cannot be written, read or resumed."""


class InUseError(RecordError):
    """A file that another process is writing."""


def printable(text: str, most: int = LINE_CHARACTERS) -> str:
    """``text`` as one line of at most ``most`` characters, with all that steers a terminal written out.

    What Python does not call printable (control characters, also those that turn the writing's
    direction, line ends, halves of surrogate pairs) becomes ``\\x1b``, ``\\u202e``, ...
    """
    head = text[: most + 1]
    if not head.isprintable():
        head = "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in head)
    return head if len(head) <= most else head[: most - 3] + "..."


def shown_name(name: object) -> str:
    """A name that somebody else chose, cut to a readable length."""
    return printable(str(name), SHOWN_CHARACTERS)


def shown(value: object) -> str:
    """``value`` as it would be written in a scene file, cut to a readable length, on one line."""
    try:
        text = str(value).lower() if isinstance(value, bool) else repr(value)
    except (ValueError, RecursionError):  # an integer or a nesting too long to print
        text = f"<{type(value).__name__} too long to print>"
    return printable(text, SHOWN_CHARACTERS)
