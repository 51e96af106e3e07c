"""What ``derod push``, ``derod check`` and ``derod info`` do."""

from __future__ import annotations

import argparse
import math
from importlib import import_module

from derod.cli import exits
from derod.cli.terminal import say, say_done, show
from derod.errors import RecordError
from derod.files.outputs import check_output
from derod.pushing import interrupts
from derod.pushing.frames import Observer, Outcome
from derod.scene import Scene, load_scene
from derod.scene.checking import check_lines, pushable_words
from derod.scene.plan import check_plan, planned

EXIT_CODES = {Outcome.COMPLETED: exits.DONE}
"""Of the outcomes; an interrupted one's is 128 and the signal's, all others are ``exits.NOT_REACHED``."""


def push(args: argparse.Namespace) -> int:
    """``derod push``."""
    scene = _scene_to_push(args)
    if not args.quiet:
        say_first(args, scene)
    watchers: list[Observer] = []
    for module in args.watchers:
        watchers += import_module(module).make_observers(args, scene)
    observers: list[Observer] = []
    if not args.quiet:
        from derod.cli.progress import Progress

        observers.append(Progress())
    from derod.api import push as push_scene
    from derod.cli.compiling import kernels_ready

    with (
        kernels_ready(scene, quiet=args.quiet),
        push_scene(
            scene,
            None if args.resume else args.output,
            observers + watchers,
            resume=args.resume,
            overwrite=args.force,
            extrapolate=args.extrapolate,
            yes_really=args.yes_really,
        ) as run,
    ):
        ending, count, extrapolated = run.ending, len(run), run.extrapolated is not None
    if ending is None:
        raise RecordError(f"{run.path}: the push left no word of how it ended")
    words = (
        f"{ending.outcome.replace('_', ' ')}: {ending.message} ({count} increments in {run.path})"
    )
    code = EXIT_CODES.get(ending.outcome, exits.NOT_REACHED)
    if ending.outcome is Outcome.INTERRUPTED:
        code = interrupts.exit_code()
    elif args.extrapolate and not extrapolated:
        words += "; it was not extrapolated"
        code = exits.NOT_REACHED if interrupts.pending() is None else interrupts.exit_code()
    if code != exits.DONE:
        say(f"derod: {words}")
    elif not args.quiet:
        say_done(words)
    return code


def say_first(args: argparse.Namespace, scene: Scene) -> None:
    """Say what is begun, before anything that takes time."""
    edges, place = scene.mesh.edges, "in space" if scene.model.dimension == 3 else "in the plane"
    stop = scene.push.stop[-1] / math.pi
    say(
        f"{args.resume or args.scene}: {edges} edges {place}, {scene.relax.method}, to {stop:g} pi; "
        "loading kernels"
    )


def check(args: argparse.Namespace) -> int:
    """``derod check``."""
    scene = load_scene(args.scene)
    if not args.yes_really:
        check_plan(scene)
    show(f"{args.scene}: {pushable_words(scene)}")
    for line in check_lines(scene):
        show(line)
    plan = planned(scene)
    show(f"  {'rows':18}{plan.rows:<14.6g}that a push records, at least")
    show(f"  {'file/MB':18}{plan.size / 1e6:<14.6g}that its file takes, at least")
    return exits.DONE


def info(args: argparse.Namespace) -> int:
    """``derod info``."""
    from derod.cli.summary import summary_lines
    from derod.record import open_run

    with open_run(args.file, verify=args.verify) as run:
        for line in summary_lines(run):
            show(line)
        if args.si:
            from derod.record.si import si_lines

            for line in si_lines(run):
                show(line)
        if args.verify:
            show(f"verified: all {len(run)} increments, events and the scene fit their checksums")
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
        forced = args.force and not str(args.rerun or "").endswith(".rrd")
        if args.scene or args.output or forced:
            raise exits.UsageError(
                "--resume FILE goes on in FILE: give no SCENE and no -o, and --force for --rerun only"
            )
        if set(given) - {"push.stop"}:
            raise exits.UsageError(
                "a resumed run keeps its method and its mesh; only --stop may change"
            )
        scene = _recorded_scene(args.resume).replace(given)
        check_output(args.resume, force=True)
    else:
        if not args.scene or not args.output:
            raise exits.UsageError("push needs SCENE and -o FILE, or --resume FILE")
        check_output(args.output, force=args.force, inputs=[args.scene])
        scene = load_scene(args.scene).replace(given)
    if not args.yes_really:
        check_plan(scene)
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
