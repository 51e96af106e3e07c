"""Writes synthetic frames into a run file until it is killed: ``python keep_writing.py FILE``."""

import sys

from derod.record import RunWriter
from tests.synthetic import make_event, make_frame, small_scene

if __name__ == "__main__":
    scene = small_scene()
    writer = RunWriter(sys.argv[1])
    writer.start(scene, 0)
    print("started", flush=True)
    for i in range(200_000):
        if i % 5 == 4:
            writer.event(make_event(i))
        writer.frame(make_frame(i, scene.mesh.edges))
