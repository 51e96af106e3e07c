"""A process that writes synthetic frames: ``python -m tests.record.writing FILE FRAMES [LIMIT]``.

Prints the number of frames after each commit. With LIMIT no file may grow beyond so many bytes.
"""

from __future__ import annotations

import resource
import signal
import sys

from derod.errors import RecordError
from derod.pushing.frames import Ending, Outcome
from derod.record import RunWriter
from tests.synthetic import make_event, make_frame, small_scene


def main(path: str, frames: int, limit: int | None = None) -> int:
    writer = RunWriter(path)
    scene = small_scene()
    writer.start(scene, 0)
    if limit is not None:
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)  # then writes fail with EFBIG
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))
    try:
        for i in range(frames):
            if i % 7 == 3:
                writer.event(make_event(i))
            writer.frame(make_frame(i, scene.mesh.edges))
            print(i + 1, flush=True)
    except RecordError as error:
        writer.finish(Ending(Outcome.RECORD_FAILED, str(error), 0.0))
        print(error, file=sys.stderr)
        return 3
    writer.finish(Ending(Outcome.COMPLETED, "all frames", 1.0))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], int(sys.argv[2]), *map(int, sys.argv[3:4])))
