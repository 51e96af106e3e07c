"""Writes frames until the disk, here the limit of a file's size, is full: ``FILE BYTES``.

Prints the number of frames that were accepted and the error.
"""

import resource
import signal
import sys

from derod.errors import RecordError
from derod.pushing.frames import Ending, Outcome
from derod.record import RunWriter
from tests.synthetic import make_frame, small_scene

if __name__ == "__main__":
    path, size = sys.argv[1], int(sys.argv[2])
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))
    scene = small_scene()
    writer = RunWriter(path)
    count = 0
    try:
        writer.start(scene, 0)
        for i in range(100_000):
            writer.frame(make_frame(i, scene.mesh.edges))
            count += 1
    except RecordError as error:
        print(count)
        print(error)
    writer.finish(Ending(Outcome.INTERRUPTED, "after the failure", 0.0))
