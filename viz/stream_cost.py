"""What streaming costs a push, and how fast a run is replayed: ``python viz/stream_cost.py``.

Pushes SCENE in turn with and without a stream to an .rrd file, a frame an increment, and compares
the push's own time, the last row's ``wall_time`` (what an increment costs), and the CPU time of its
process. The stream is drawn by another process: on a machine that has something else to do for
every core, the wall-clock shows that; the CPU time does not.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import derod
from derod.views.stream.replay import replay_file
from derod.views.stream.target import parse_target
from derod.views.stream.viewers import close_recording

ROOT = Path(__file__).resolve().parent.parent
PUSH = """
import sys, time
import derod
from derod.views.stream.observer import RerunStream
scene = derod.load_scene(sys.argv[1])
class Clock:
    def start(self, scene, first): pass
    def event(self, event): pass
    def frame(self, frame):
        if frame.row["increment"] == 0:
            self.cpu, self.wall = time.process_time(), time.perf_counter()
    def finish(self, ending):
        self.cpu = time.process_time() - self.cpu
        self.wall = time.perf_counter() - self.wall
clock = Clock()
observers = [clock] + ([RerunStream(sys.argv[3])] if len(sys.argv) > 3 else [])
with derod.push(scene, sys.argv[2], observers, overwrite=True) as run:
    print(clock.wall, clock.cpu, len(run))
"""


def measure(scene: str, folder: Path, stream: bool) -> tuple[float, float, int]:
    """Seconds of wall-clock and CPU from the first increment to the last, and their number."""
    words = [sys.executable, "-c", PUSH, scene, str(folder / "run.h5")]
    if stream:
        words.append(str(folder / "run.rrd"))
    done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=True)
    wall, cpu, count = done.stdout.split()
    return float(wall), float(cpu), int(count)


def main() -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scene", nargs="?", default=str(ROOT / "runs" / "paper-text.toml"))
    parser.add_argument("--times", type=int, default=7)
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        measure(args.scene, folder, stream=False)  # compiles
        plain, streamed = [], []
        for _ in range(args.times):
            plain.append(measure(args.scene, folder, stream=False))
            streamed.append(measure(args.scene, folder, stream=True))
        for k, what in ((0, "wall-clock"), (1, "CPU of the push")):
            a, b = min(row[k] for row in plain), min(row[k] for row in streamed)
            print(
                f"{what}: {a:.3f} s without, {b:.3f} s with a stream "
                f"({100 * (b / a - 1):+.1f} %), {plain[0][2]} increments, best of {args.times}"
            )
        print(f"load of this machine: {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores")
        replay = []
        for _ in range(3):
            began = time.perf_counter()
            opened = replay_file(
                str(folder / "run.h5"), parse_target(str(folder / "a.rrd")), "curvature"
            )
            close_recording(opened.recording, 60.0)
            replay.append(time.perf_counter() - began)
        with derod.open_run(folder / "run.h5") as run:
            edges, count = run.scene.mesh.edges, len(run)
        print(f"replay: {min(replay):.2f} s for {count} increments at {edges} edges")
        print(f"        {300 * min(replay) / count:.2f} s for 300")
    return 0


if __name__ == "__main__":
    sys.exit(main())
