"""What ``derod push``, ``derod check`` and ``derod info`` do."""

from __future__ import annotations

import argparse
import os
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from typing import NoReturn

from derod import exits
from derod.errors import RecordError
from derod.frames import Observer, Outcome
from derod.scene import Scene, load_scene
from derod.scene.checking import check_lines, pushable_words

EXIT_CODES = {
    Outcome.COMPLETED: exits.DONE,
    Outcome.INTERRUPTED: exits.INTERRUPTED,
}
"""Of the outcomes; all others are ``exits.NOT_REACHED``."""


def push(args: argparse.Namespace) -> int:
    """``derod push``."""
    from derod.api import push as push_scene

    scene = _scene_to_push(args)
    observers: list[Observer] = []
    if not args.quiet:
        from derod.progress import Progress

        observers.append(Progress())
    for module in args.watchers:
        observers += import_module(module).make_observers(args, scene)
    with _terminable():
        run = push_scene(
            scene,
            None if args.resume else args.output,
            observers,
            resume=args.resume,
            overwrite=args.force,
            extrapolate=args.extrapolate,
        )
    with run:
        ending, count = run.ending, len(run)
    if ending is None:
        raise RecordError(f"{run.path}: the push left no word of how it ended")
    code = EXIT_CODES.get(ending.outcome, exits.NOT_REACHED)
    words = f"{ending.outcome.replace('_', ' ')}: {ending.message}"
    if code != exits.DONE:
        print(f"derod: {words} ({count} increments in {run.path})", file=sys.stderr)
    elif not args.quiet:
        print(f"{words} ({count} increments in {run.path})")
    return code


def check(args: argparse.Namespace) -> int:
    """``derod check``."""
    scene = load_scene(args.scene)
    print(f"{args.scene}: {pushable_words(scene)}")
    for line in check_lines(scene):
        print(line)
    return exits.DONE


def info(args: argparse.Namespace) -> int:
    """``derod info``."""
    from derod.record import open_run
    from derod.summary import summary_lines

    with open_run(args.file) as run:
        for line in summary_lines(run):
            print(line)
        if args.si:
            from derod.si import si_lines

            for line in si_lines(run):
                print(line)
    return exits.DONE


def _scene_to_push(args: argparse.Namespace) -> Scene:
    """The scene of the file or of the run to resume, with what the command line changes."""
    changes = {
        "relax.method": args.method,
        "mesh.edges": args.edges,
        "push.stop": None if args.stop is None else _stops(args.stop),
    }
    given = {key: value for key, value in changes.items() if value is not None}
    if args.resume:
        if args.scene or args.output or args.force:
            raise exits.UsageError("--resume FILE goes on in FILE: give no SCENE, -o or --force")
        if set(given) - {"push.stop"}:
            raise exits.UsageError(
                "a resumed run keeps its method and its mesh; only --stop may change"
            )
        return _recorded_scene(args.resume).replace(given)
    if not args.scene or not args.output:
        raise exits.UsageError("push needs SCENE and -o FILE, or --resume FILE")
    scene = load_scene(args.scene).replace(given)
    if os.path.lexists(args.output) and not args.force:
        raise exits.UsageError(f"{args.output}: exists already; --force replaces it")
    return scene


def _recorded_scene(path: str) -> Scene:
    from derod.record import open_run

    try:
        with open_run(path) as run:
            return run.scene
    except RecordError as error:
        raise exits.UsageError(str(error)) from error


def _stops(text: str) -> str | list[str]:
    parts = [part.strip() for part in text.split(",")]
    return parts[0] if len(parts) == 1 else parts


@contextmanager
def _terminable() -> Iterator[None]:
    """Let SIGTERM end a push as Ctrl-C does, with the file closed and the ending written."""

    def interrupt(number: int, frame: object) -> NoReturn:
        raise KeyboardInterrupt

    if threading.current_thread() is not threading.main_thread():
        yield  # signals go to the main thread only
        return
    before = signal.signal(signal.SIGTERM, interrupt)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)
