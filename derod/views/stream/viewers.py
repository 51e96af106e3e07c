"""Recordings bound to a file, a viewer or a web server, each with its limits.

Everything that listens is bound to 127.0.0.1. Whoever is not there is found out by a probe of the
port, since connecting to nobody blocks.
"""

from __future__ import annotations

import importlib.util
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import quote

from derod.files.outputs import OutputError, replacing
from derod.views.stream.target import PORT, WEB_PORT, Target, TargetError, proxy_url

HOST = "127.0.0.1"
VIEWER_MEMORY = "1GiB"
SERVER_MEMORY = "512MiB"
START_UP = 20.0  # s that a viewer of our own may take to listen
_files: dict[Any, ExitStack] = {}
"""The files under way, by their recordings."""


@dataclass
class Opened:
    """A recording and what was started for it."""

    recording: Any  # rerun.RecordingStream
    process: subprocess.Popen[bytes] | None = None  # ours, goes on when we end
    url: str | None = None  # for a browser


def open_recording(
    target: Target,
    name: str,
    waiting: Callable[[], None] = lambda: None,
    recording_id: str | None = None,
) -> Opened:
    """A rerun recording that goes to ``target``. ``waiting`` is called now and then meanwhile.

    Raises TargetError where nobody answers, OutputError where the file cannot be written.
    """
    import rerun as rr

    recording = rr.RecordingStream("derod", recording_id=recording_id)
    recording.set_log_time_enabled(False)
    recording.set_log_tick_enabled(False)
    opened = Opened(recording)
    if target.kind == "file":
        stack = ExitStack()
        passing = stack.enter_context(replacing(target.place, force=target.force))
        recording.save(str(passing))
        _files[recording] = stack
    elif target.kind == "connect":
        host, port = target.address
        if not listens(host, port):
            raise TargetError(f"no viewer listens at {target.place}")
        recording.connect_grpc(target.place)
    else:
        port = free_port(PORT)
        web = free_port(WEB_PORT, port) if target.kind == "web" else None
        opened.process = start_viewer(port, web, waiting)
        recording.connect_grpc(proxy_url(HOST, port))
        if web is not None:
            opened.url = f"http://{HOST}:{web}/?url={quote(proxy_url(HOST, port), safe='')}"
    recording.send_recording_name(name)
    return opened


def listens(host: str, port: int, patience: float = 0.5) -> bool:
    """Whether somebody listens there."""
    try:
        with socket.create_connection((host, port), timeout=patience):
            return True
    except OSError:
        return False


def free_port(wanted: int, other: int | None = None) -> int:
    """``wanted`` if it is free on this machine, else one that is; never ``other``."""
    for port in (wanted, 0, 0):
        with socket.socket() as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            try:
                probe.bind((HOST, port))
            except OSError:
                continue
            found = int(probe.getsockname()[1])
        if found != other:
            return found
    raise TargetError(f"no free port on {HOST}")


def program() -> list[str]:
    """The rerun viewer's own binary, so that what we start is what we can end."""
    found = importlib.util.find_spec("rerun_cli")
    for folder in (found.submodule_search_locations or []) if found else []:
        for name in ("rerun", "rerun.exe"):
            if (Path(folder) / name).is_file():
                return [str(Path(folder) / name)]
    return [sys.executable, "-m", "rerun"]


def start_viewer(
    port: int,
    web_port: int | None,
    waiting: Callable[[], None] = lambda: None,
    options: Sequence[str] = (),
) -> subprocess.Popen[bytes]:
    """Start a native viewer, or with ``web_port`` a server of the web viewer; wait until it
    listens. ``options``: more words of its command line.

    It is a session of its own: it outlives us, and our Ctrl-C does not reach it.
    """
    command = [*program(), "--bind", HOST, "--port", str(port)]
    command += ["--memory-limit", VIEWER_MEMORY, "--server-memory-limit", SERVER_MEMORY, *options]
    if web_port is None:
        command += ["--hide-welcome-screen", "--expect-data-soon"]
    else:
        command += ["--serve-web", "--web-viewer-port", str(web_port)]
    process = subprocess.Popen(
        command,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )
    ends = time.monotonic() + START_UP
    while time.monotonic() < ends:
        if process.poll() is not None:
            raise TargetError(
                f"the rerun viewer ended at once (exit code {process.returncode}); "
                "is there a display?"
            )
        if listens(HOST, port):
            return process
        waiting()
        time.sleep(0.1)
    process.kill()
    raise TargetError(f"the rerun viewer did not listen within {START_UP:g} s")


def close_recording(recording: Any, patience: float) -> str | None:
    """Send what is left and let go; returns what went wrong, or None.

    A recording to a file gets the file's name now, when it is whole.
    """
    file = _files.pop(recording, None)
    try:
        recording.flush(timeout_sec=patience)
    except (RuntimeError, OSError, ValueError) as error:
        if file is not None:
            file.__exit__(type(error), error, None)
        return f"not all reached the viewer: {error}"
    recording.disconnect()
    try:
        if file is not None:
            file.close()
    except OutputError as error:
        return str(error)
    return None


def drop_recording(recording: Any) -> None:
    """Let go of a recording that is not finished; a file of it is removed."""
    file = _files.pop(recording, None)
    if file is not None:
        stop = ConnectionAbortedError("not finished")
        with suppress(ConnectionAbortedError, OutputError):
            file.__exit__(type(stop), stop, None)
