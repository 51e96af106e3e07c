"""Pushes that are streamed: what arrives, and that nothing on the other side can hurt them."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from derod.pushing.frames import Frame
from derod.record import MemoryRun
from derod.views.stream import observer
from derod.views.stream.observer import RerunStream
from derod.views.stream.pipe import Pipe
from derod.views.stream.target import proxy_url
from derod.views.stream.viewers import free_port, listens, program
from tests.stream.reading import read_rrd, seconds
from tests.synthetic import drive, small_scene

SHAPES = (
    "world/rod/tube",
    "world/rod/stripe",
    "world/rod/frame",
    "world/drop",
    "world/clamps/end",
    "world/menisci/points",
    "world/menisci/forces",
)
PLOTS = (
    "plots/tension",
    "plots/energy/hat",
    "plots/energy/bend",
    "plots/energy/twist",
    "plots/energy/wall",
    "plots/energy/capillary",
    "plots/wetted_length",
    "plots/unstable_modes",
    "plots/residual",
)


class At:
    """An observer that does something before a frame."""

    def __init__(self, increment, action):
        self.increment, self.action = increment, action

    def start(self, scene, first_increment): ...

    def event(self, event): ...

    def frame(self, frame: Frame):
        if frame.row["increment"] == self.increment:
            self.action()

    def finish(self, ending): ...


@pytest.fixture
def server():
    """A rerun server without a viewer, ours to stop and to kill."""
    port = free_port(0)
    command = [*program(), "--serve-grpc", "--bind", "127.0.0.1", "--port", str(port)]
    command += ["--server-memory-limit", "64MiB"]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    ends = time.monotonic() + 20
    while not listens("127.0.0.1", port) and time.monotonic() < ends:
        time.sleep(0.05)
    process.url = proxy_url("127.0.0.1", port)
    yield process
    process.kill()
    process.wait()


def test_a_file_holds_every_increment_on_its_timelines(tmp_path):
    scene, memory = small_scene(), MemoryRun()
    path = tmp_path / "a.rrd"
    drive(scene, [memory, RerunStream(str(path), "tension")])
    contents = read_rrd(path)
    delta = memory.table["end_shortening"]
    for entity in (*SHAPES, *PLOTS):
        assert contents[entity].rows == len(memory), entity
        assert contents[entity].times["increment"] == list(range(len(memory)))
        assert seconds(contents[entity].times["end_shortening"]) == pytest.approx(delta, abs=1e-8)
    t = [value[0] for value in contents["plots/tension"].values("Scalars:scalars")]
    assert t == memory.table["end_tension"].tolist()
    assert "Mesh3D:albedo_factor" in contents["world/drop/surface"].static
    assert "Mesh3D:triangle_indices" in contents["world/rod/tube"].static
    assert len(contents["world/rod/tube"].values("Mesh3D:vertex_positions")[0]) == 25 * 10
    words = [text[0] for text in contents["events"].values("TextLog:text")]
    assert len(words) == len(memory.events) + 1
    assert words[0].startswith("instability at")
    assert {level[0] for level in contents["events"].values("TextLog:level")} == {"INFO"}
    for entity in ("scale", "menisci", "wall", "edge", "director"):
        assert contents[f"legend/{entity}"].static, entity
    assert "LineStrips3D:strips" in contents["world/drop/edge"].static
    assert words[-1].startswith("completed")
    assert contents.blueprints == 1


def test_a_push_that_is_killed_leaves_a_whole_file(tmp_path):
    path = tmp_path / "killed.rrd"
    code = (
        "import os, signal, sys\n"
        "from tests.stream.test_stream import At, drive, small_scene, RerunStream\n"
        "kill = At(20, lambda: os.kill(os.getpid(), signal.SIGKILL))\n"
        f"drive(small_scene(), [RerunStream({str(path)!r}), kill])\n"
    )
    done = subprocess.run([sys.executable, "-c", code], check=False)
    assert done.returncode == -signal.SIGKILL
    ends = time.monotonic() + 15
    rows = 0
    while time.monotonic() < ends and rows < 21:  # the relay outlives the push by a moment
        time.sleep(0.3)
        try:
            rows = read_rrd(path)["plots/tension"].rows
        except (OSError, ValueError, KeyError, AssertionError, RuntimeError):
            continue
    assert rows == 21


def test_a_viewer_that_is_absent_is_said_once_and_harms_nothing(capfd):
    memory = MemoryRun()
    began = time.monotonic()
    drive(small_scene(), [memory, RerunStream(f"connect=127.0.0.1:{free_port(0)}")])
    assert time.monotonic() - began < 10
    assert memory.ending.outcome == "completed"
    lines = capfd.readouterr().err.strip().splitlines()
    assert len(lines) == 1
    assert "no viewer listens at" in lines[0]


def test_a_viewer_that_is_killed_harms_nothing(server):
    memory = MemoryRun()
    stream = RerunStream(f"connect={server.url}")
    began = time.monotonic()
    drive(small_scene(push__stop="1.5 pi"), [memory, stream, At(50, server.kill)])
    assert time.monotonic() - began < 25
    assert memory.ending.outcome == "completed"
    assert len(memory) == 150


def test_a_viewer_that_stands_still_harms_nothing(server, monkeypatch, capfd):
    monkeypatch.setitem(observer.PATIENCE, "connect", 1.5)
    scene = small_scene(mesh__edges=800, push__stop="6 pi", rod__length=25)
    memory = MemoryRun()

    def freeze():
        time.sleep(1.0)  # let the relay connect first
        os.kill(server.pid, signal.SIGSTOP)

    began = time.monotonic()
    drive(scene, [memory, RerunStream(f"connect={server.url}"), At(10, freeze)])
    assert time.monotonic() - began < 25
    assert memory.ending.outcome == "completed"
    assert len(memory) == 600
    assert "the run itself is whole" in capfd.readouterr().err


def test_a_relay_that_dies_harms_nothing(tmp_path, capfd):
    stream, memory = RerunStream(str(tmp_path / "b.rrd")), MemoryRun()
    drive(small_scene(), [memory, stream, At(10, lambda: stream.pipe.child.kill())])
    assert memory.ending.outcome == "completed"
    assert "ended early" in capfd.readouterr().err


def test_a_full_pipe_drops_messages_and_never_waits():
    pipe = Pipe("tests.stream.deaf", most_backlog=2**21)
    began = time.monotonic()
    for _ in range(400):
        pipe.send(np.zeros(2**14))
    assert time.monotonic() - began < 2
    assert pipe.dropped > 300
    assert pipe.drain(0.5) is False
    assert pipe.child.poll() is not None


def test_rerun_is_imported_by_nobody_but_the_relay(tmp_path):
    scene = tmp_path / "scene.toml"
    scene.write_text(small_scene().text)
    for extra in ([], ["--rerun", str(tmp_path / "a.rrd")]):
        code = (
            "import sys, derod.api, derod.cli.commands\n"
            "from derod import cli\n"
            "from derod.views.stream.cli import make_observers\n"
            f"words = ['push', {str(scene)!r}, '-o', 'x.h5', *{extra}]\n"
            "args = cli.build_parser().parse_args(words)\n"
            "from tests.synthetic import drive\n"
            "scene = derod.load_scene(args.scene)\n"
            "drive(scene, make_observers(args, scene))\n"
            "sys.exit('rerun' in sys.modules)\n"
        )
        assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_a_viewer_without_a_display_harms_nothing(monkeypatch):
    """It may end at once, before it listens, or after it took some of the data."""
    memory = MemoryRun()
    environment = {k: v for k, v in os.environ.items() if k not in ("DISPLAY", "WAYLAND_DISPLAY")}
    monkeypatch.setattr(os, "environ", environment)
    began = time.monotonic()
    drive(small_scene(), [memory, RerunStream("spawn")])
    assert memory.ending.outcome == "completed"
    assert len(memory) == 40
    assert time.monotonic() - began < 30
