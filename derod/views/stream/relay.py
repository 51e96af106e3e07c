"""The process that draws a push: pickles on standard input, a byte on standard output for each.

It ends when its input does: also when the push was killed, so that an .rrd file is whole all the
same. A viewer that takes nothing for STALLED seconds ends it.
"""

from __future__ import annotations

import os
import pickle
import signal
import sys
from collections.abc import Iterator
from pathlib import Path
from queue import Empty, Queue
from threading import Thread
from typing import Any, BinaryIO

import numpy as np

from derod.files.outputs import OutputError
from derod.pushing.frames import Ending, Event, Frame
from derod.pushing.rows import ROW
from derod.terminal import say
from derod.views.stream.drawing import Batch, Column, draw, draw_shapes
from derod.views.stream.messages import Begin, Step
from derod.views.stream.target import TargetError

STALLED = 30
TOGETHER = 16  # messages drawn at once
NICENESS = 10  # the push comes first
LAST_WORDS = 10.0  # s for what is under way when all is said
DONE, FAILED = 0, 1


def main() -> int:
    """Read messages to the end and draw them."""
    if hasattr(os, "nice"):
        os.nice(NICENESS)
    source = sys.stdin.buffer
    heartbeat()
    try:
        begin: Begin = pickle.load(source)
    except EOFError:
        return DONE
    try:
        return show(begin, source)
    except (TargetError, OutputError) as error:
        return complain(str(error))
    except ImportError as error:
        return complain(f"rerun cannot be imported: {error}")


def show(begin: Begin, source: BinaryIO) -> int:
    """Draw what comes until there is no more."""
    from derod.views.stream.viewers import close_recording, open_recording

    name = Path(begin.scene.path or "push").name
    opened = open_recording(begin.target, name, heartbeat)
    if opened.url is not None and opened.process is not None:
        words = f"web viewer: {opened.url} (it stays until: kill {opened.process.pid})"
        say(f"derod: {words}")
    from derod.views.stream.stage import Stage

    stage = Stage(opened.recording, begin.scene, begin.color, live=True)
    last = 0
    for messages in bundles(source):
        alarm(STALLED)
        frames = [message for message in messages if isinstance(message, Frame)]
        if frames:
            batch = Batch.of(frames)
            last = int(batch.rows["increment"][-1])
            stage.send(draw(batch, begin.scene, begin.color), batch.rows)
        stage.events([message for message in messages if isinstance(message, Event)])
        for message in messages:
            if isinstance(message, Step):
                show_step(stage, message, begin.color)
            elif isinstance(message, Ending):
                stage.ending(message, last)
        heartbeat()
        alarm(0)
    alarm(STALLED)
    problem = close_recording(opened.recording, LAST_WORDS)
    return DONE if problem is None else complain(problem)


def bundles(source: BinaryIO) -> Iterator[list[Any]]:
    """The messages, as many at a time as are there; ends when the push does, also amid a
    message.
    """
    queue: Queue[Any] = Queue(maxsize=2 * TOGETHER)

    def read() -> None:
        try:
            while True:
                queue.put(pickle.load(source))
        except (EOFError, pickle.UnpicklingError):
            queue.put(None)

    Thread(target=read, daemon=True).start()
    going_on = True
    while going_on:
        messages = [queue.get()]
        while len(messages) < TOGETHER and messages[-1] is not None:
            try:
                messages.append(queue.get_nowait())
            except Empty:
                break
        going_on = messages[-1] is not None
        if messages := [message for message in messages if message is not None]:
            yield messages


def show_step(stage: Any, step: Step, color: str) -> None:
    """Draw a step of a relaxation, on a timeline of its own."""
    import rerun as rr

    batch = batch_of(step, stage.scene.clamps.end_rotation)
    indexes = [rr.TimeColumn("relaxation", sequence=[step.number])]
    residual = np.array([np.log10(max(step.residual, 1e-300))])
    plot = Column("plots/relaxation", "Scalars", {"scalars": [residual]})
    word = np.array(
        [
            f"step {step.number} toward increment {step.increment}, "
            f"{step.end_shortening / np.pi:.4f} pi: residual {step.residual:.3g}"
        ]
    )
    log = Column("events", "TextLog", {"text": [word]})
    stage.send_at([*draw_shapes(batch, stage.scene, color), plot, log], indexes)


def batch_of(step: Step, end_rotation: float) -> Batch:
    """A step as a frame that can be drawn; its arc length is that of its chords."""
    row = np.zeros(1, ROW)
    row["increment"], row["end_shortening"] = step.increment, step.end_shortening
    row["end_rotation"], row["holonomy"] = end_rotation, step.holonomy
    row["meniscus_a"], row["meniscus_b"] = step.menisci
    row["force_a"], row["force_b"] = step.forces
    chords = np.linalg.norm(np.diff(step.positions, axis=0), axis=1)
    arc_length = np.concatenate([[0.0], np.cumsum(chords)])
    return Batch(
        row, step.positions[None], arc_length[None], step.drop_center[None], step.edge_tension[None]
    )


def heartbeat() -> None:
    """Tell the push that we are alive; it may be gone."""
    try:
        os.write(1, b".")
    except OSError:
        return


def alarm(seconds: int) -> None:
    """End this process if the next message takes longer: rerun blocks on a viewer that stands
    still.
    """
    if hasattr(signal, "alarm"):
        signal.alarm(seconds)


def complain(text: str) -> int:
    """Say why nothing is shown."""
    say(f"derod: rerun: {text}; the run goes on unseen")
    return FAILED


if __name__ == "__main__":
    code = main()
    os._exit(code)  # rerun's own clean-up may wait for a viewer for ever
