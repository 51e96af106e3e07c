"""What ``derod push``, ``derod check`` and ``derod info`` do."""

from __future__ import annotations

import argparse
import shlex
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from importlib import import_module
from typing import Any

from derod import exits, scenes
from derod.errors import RecordError, SceneError, shown
from derod.files.outputs import check_output
from derod.pushing import interrupts
from derod.pushing.frames import Observer, Outcome
from derod.scene import Scene
from derod.scene.axis import AXES, Axis, axis_of
from derod.scene.checking import check_lines, pushable_words
from derod.scene.directors import check_pushable
from derod.scene.plan import check_plan, planned
from derod.scene.program import legs
from derod.terminal import say, say_done, show
from derod.views import file_kinds as kinds

OPTIONS = {"relax.method": "--method", "mesh.edges": "--edges", "push.stop": "--stop"}
"""The keys of a scene that the command line changes, and what changes them."""

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
        from derod.views.progress import Progress

        observers.append(Progress())
    from derod.api import push as push_scene
    from derod.cli.compiling import kernels_ready
    from derod.record.ending import ending_words

    with (
        blaming_the_command_line(changed(args), scene),
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
    words = f"{ending_words(ending)} ({count} increments in {run.path})"
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
        file = shlex.quote(str(run.path))
        say_done(f"next: derod info {file}, derod plot {file}, derod view {file}")
    return code


def say_first(args: argparse.Namespace, scene: Scene) -> None:
    """Say what is begun, before anything that takes time."""
    edges, place = scene.mesh.edges, "in space" if scene.model.dimension == 3 else "in the plane"
    last = legs(scene)[-1]
    goal = AXES[last.control].both(last.stop)
    words = "" if last.control == "end_shortening" else f"{AXES[last.control].name} "
    say(
        f"{args.resume or args.scene}: {edges} edges {place}, {scene.relax.method}, to {words}{goal}; "
        "loading kernels"
    )


def check(args: argparse.Namespace) -> int:
    """``derod check``."""
    kinds.expect(scenes.file_of(args.scene), kinds.SCENES)
    scene = scenes.read_scene(args.scene)
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

    kinds.expect(args.file, kinds.TABLES | kinds.DIAGRAMS)
    if kinds.kind_of(args.file) is kinds.Kind.DIAGRAM:
        return _info_of_diagram(args)
    if kinds.kind_of(args.file) is kinds.Kind.SWEEP:
        from derod.cli.sweeps import show_info

        return show_info(args)
    if kinds.kind_of(args.file) is kinds.Kind.BRANCHES:
        return _info_of_branches(args)
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


def _info_of_diagram(args: argparse.Namespace) -> int:
    from derod.cli.diagram_summary import diagram_lines
    from derod.diagram.reading import read_diagram

    if args.si:
        raise exits.UsageError(f"{args.file}: --si is for run files, and this is a diagram file")
    diagram = read_diagram(args.file)  # held against its checksums
    for line in diagram_lines(diagram):
        show(line)
    if args.verify:
        show(f"verified: all {len(diagram.paths)} paths and the head fit their checksums")
    return exits.DONE


def _info_of_branches(args: argparse.Namespace) -> int:
    from derod.branches import open_branches
    from derod.cli.branch_summary import branch_lines

    if args.si:
        raise exits.UsageError(f"{args.file}: --si is for run files, and this is a branch file")
    with open_branches(args.file) as file:
        for line in branch_lines(file):
            show(line)
        if args.verify:
            if not file.checksummed:
                raise RecordError(f"{args.file}: is not checksummed: it was written by derod 0.1")
            show(f"verified: all {len(file)} branches and the head fit their checksums")
    return exits.DONE


def changed(args: argparse.Namespace) -> dict[str, Any]:
    """The keys of the scene that the command line changes, and their values."""
    changes = {
        "relax.method": args.method,
        "mesh.edges": args.edges,
        "push.stop": None if args.stop is None else _stops(args.stop),
    }
    return {key: value for key, value in changes.items() if value is not None}


@contextmanager
def blaming_the_command_line(given: Mapping[str, Any], scene: Scene) -> Iterator[None]:
    """Let errors of values that the command line gave name the option, not a file."""
    try:
        yield
    except SceneError as error:
        for key, option in OPTIONS.items():
            if key in given and error.key is not None and error.key.partition("[")[0] == key:
                raise exits.UsageError(_blame(option, given[key], error, axis_of(scene))) from error
        raise


def _blame(option: str, value: Any, error: SceneError, axis: Axis) -> str:
    line = f"{option} = {shown(', '.join(value) if isinstance(value, list) else value)}"
    if isinstance(value, list) and error.key is not None and error.key.endswith("]"):
        which = int(error.key.partition("[")[2][:-1])
        line += f": part {which + 1}, {shown(value[which])},"
    if option == "--stop" and isinstance(error.value, float):
        line += f" = {axis.both(error.value)}"
    return f"{line} {error.problem}" + (f"; allowed: {error.allowed}" if error.allowed else "")


def _scene_to_push(args: argparse.Namespace) -> Scene:
    """The scene of the file or of the run to resume, with what the command line changes.

    Where no output is named it gets its default name.
    """
    given = changed(args)
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
        kinds.expect(args.resume, kinds.RUNS, "--resume")
        recorded = _recorded_scene(args.resume)
        with blaming_the_command_line(given, recorded):
            scene = recorded.replace(given)
        check_output(args.resume, force=True)
    else:
        if not args.scene:
            raise exits.UsageError(
                "push needs SCENE, a file or a shipped one such as quick (derod scenes), or --resume FILE"
            )
        file = scenes.file_of(args.scene)
        kinds.expect(file, kinds.SCENES, "SCENE")
        original = scenes.read_scene(args.scene)
        ask = "--force replaces it"
        if args.output is None:
            args.output = kinds.default_output(args.scene, ".h5")
            ask = "--force replaces it, -o FILE writes another, --resume goes on with it"
        check_output(args.output, force=args.force, inputs=[file], ask=ask)
        with blaming_the_command_line(given, original):
            scene = original.replace(given)
    check_pushable(scene)
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
