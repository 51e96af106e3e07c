"""Where a stream goes, read from what the user typed; nothing heavy is imported here."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from derod.errors import DerodError

PORT = 9876
WEB_PORT = 9090
ALLOWED = "spawn, connect, connect=URL, connect=HOST:PORT, web or FILE.rrd"


class TargetError(DerodError):
    """A place that nothing can be streamed to."""


@dataclass(frozen=True, slots=True)
class Target:
    """kind: "spawn" (a viewer of our own), "connect" (one that runs), "web" (a browser), "file"."""

    kind: str
    place: str = ""  # the URL, or the file
    force: bool = False  # an existing file may be replaced

    @property
    def address(self) -> tuple[str, int]:
        """Host and port of a viewer to connect to."""
        found = re.fullmatch(r"rerun\+https?://(\[[^\]]+\]|[^:/]+):(\d+)/proxy", self.place)
        if found is None:
            raise TargetError(f"{self.place}: allowed: rerun+http://HOST:PORT/proxy")
        return found[1].strip("[]"), int(found[2])

    def __str__(self) -> str:
        return self.place or self.kind


def proxy_url(host: str, port: int) -> str:
    """The address of a viewer's or server's proxy, as rerun wants it."""
    return f"rerun+http://{host}:{port}/proxy"


def parse_target(text: str, *, force: bool = False, option: str = "rerun") -> Target:
    """Read ``spawn``, ``connect[=URL]``, ``web`` or ``FILE.rrd``; ``force`` lets the file be replaced.

    ``option`` is what messages call it.

    Raises TargetError.
    """
    kind, _, place = text.partition("=")
    if text in ("spawn", "web"):
        return Target(text)
    if kind == "connect":
        if re.fullmatch(r"[^:/]+:\d+", place):
            host, _, port = place.partition(":")
            place = proxy_url(host, int(port))
        target = Target("connect", place or proxy_url("127.0.0.1", PORT))
        _ = target.address
        return target
    if text.endswith(".rrd"):
        folder = Path(text).parent
        if not folder.is_dir():
            raise TargetError(f"{text}: no such folder; allowed: a file in an existing folder")
        return Target("file", text, force)
    raise TargetError(f"{option} = {text!r}: nowhere to stream to; allowed: {ALLOWED}")
