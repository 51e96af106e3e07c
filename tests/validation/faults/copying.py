"""Copies a run for its resume again and again: ``python -m tests.validation.faults.copying FILE [once]``."""

import sys

from derod.pushing.frames import Ending, Outcome
from derod.record import resume_copy

if __name__ == "__main__":
    print("begins", flush=True)
    while True:
        resume_copy(sys.argv[1]).finish(Ending(Outcome.INTERRUPTED, "copied", 0.0))
        if sys.argv[2:]:
            break
