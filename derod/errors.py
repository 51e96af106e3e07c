"""The errors derod raises on purpose: what the user can act on, said in one line."""

from __future__ import annotations

SHOWN_CHARACTERS = 60


class DerodError(Exception):
    """Base of every error that derod raises on purpose."""


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
            line += f" {key}"
        if value is not None:
            line += f" = {written or shown(value)}"
        line += f" {problem}"
        if allowed is not None:
            line += f"; allowed: {allowed}"
        super().__init__(" ".join(line.split()))


class RecordError(DerodError):
    """A run file that cannot be written, read or resumed."""


def shown(value: object) -> str:
    """``value`` as it would be written in a scene file, cut to a readable length, on one line."""
    try:
        text = str(value).lower() if isinstance(value, bool) else repr(value)
    except (ValueError, RecursionError):  # an integer or a nesting too long to print
        text = f"<{type(value).__name__} too long to print>"
    return text if len(text) <= SHOWN_CHARACTERS else text[: SHOWN_CHARACTERS - 3] + "..."
