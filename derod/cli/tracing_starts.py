"""Where ``derod trace`` begins: the straight rod, an increment of a run, a state of a branch file."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from derod import exits, scenes
from derod.errors import SceneError
from derod.scene import Scene, parse_scene
from derod.scene.axis import both
from derod.scene.controls import HELD
from derod.views import file_kinds as kinds

if TYPE_CHECKING:
    from derod.rod.state import State
    from derod.tracing.arc import Arc
    from derod.tracing.path import Limits, Path


@dataclass(frozen=True)
class Start:
    """What is traced, and how it is begun."""

    scene: Scene
    arc: Arc
    follow: Callable[[Limits, str], Path]
    slides: bool


def arc_of(scene: Scene, control: str) -> Arc:
    """Return what steps along paths of a scene in a control. Raises SceneError."""
    needs = HELD[control].needs
    if needs == "drop" and scene.drop is None:
        raise SceneError(f"has no drop, and {HELD[control].words} is one's", file=scene.path)
    if needs == "space" and scene.model.dimension != 3:
        raise SceneError(
            "is too few for an end rotation", file=scene.path, key="model.dimension",
            value=scene.model.dimension, allowed="3",
        )  # fmt: skip
    if scene.has_frames:
        raise SceneError(
            "has a section with directions of its own; trace and explore follow "
            "isotropic, naturally straight rods",
            file=scene.path,
        )
    from derod.equilibrium.system import System
    from derod.pushing.controls import CONTROLS
    from derod.tracing.arc import Arc

    return Arc(System(scene), CONTROLS[control])


def begin(args: argparse.Namespace, kind: kinds.Kind, at: float | None) -> Start:
    """Return the start that the arguments name. Raises UsageError, SceneError, RecordError."""
    if kind is kinds.Kind.RUN:
        return _from_run(args, at)
    if kind is kinds.Kind.BRANCHES:
        return _from_branches(args, at)
    if at is not None or args.path is not None:
        raise exits.UsageError(
            f"{args.file}: --at and --path are for run and branch files; "
            "a scene's paths start at the straight rod"
        )
    if args.control not in ("end_shortening", "end_tension"):
        raise exits.UsageError(
            f"--control = {args.control}: allowed for a scene: end_shortening, end_tension; "
            "from a run or a branch file: any"
        )
    scene = scenes.read_scene(args.file)
    if args.edges is not None:
        scene = scene.replace({"mesh.edges": args.edges})
    arc = arc_of(scene, args.control)

    def follow(limits: Limits, name: str) -> Path:
        from derod.tracing.path import follow as follow_path
        from derod.tracing.straight import StraightError, buckled, bucklings

        found = bucklings(arc.system, args.mode)
        if len(found) < args.mode:
            raise StraightError(f"--mode = {args.mode}: the straight rod has {len(found)} in reach")
        one = found[args.mode - 1]
        first = buckled(arc, one)
        if first is None:
            raise StraightError(f"no state was found beside the straight rod at {one.tension:.8g}")
        path = follow_path(arc, first, limits, name)
        tension = one.tension * arc.system.bending
        path.begins = f"the straight rod buckles at the end tension {tension:.8g}"
        return path

    return Start(scene, arc, follow, args.control == "end_tension")


def through(arc: Arc, state: State) -> Callable[[Limits, str], Path]:
    """Return what follows the path through a state both ways."""

    def follow(limits: Limits, name: str) -> Path:
        from derod.tracing.starting import both_ways
        from derod.tracing.straight import StraightError

        value = arc.control.value(state)
        if not limits.low <= value <= limits.high:
            raise exits.UsageError(
                f"--to: the state to start from has {arc.control.name} = {value:.6g}; "
                "allowed: a range round it"
            )
        path = both_ways(arc, state, limits, name)
        if path is None:
            raise StraightError("the Hessian is singular at the state to start from")
        return path

    return follow


def _from_run(args: argparse.Namespace, at: float | None) -> Start:
    from derod.pushing.encode import decode
    from derod.record import open_run
    from derod.scene.program import legs
    from derod.tracing.starting import landed

    if at is None or args.path is not None:
        raise exits.UsageError(f"{args.file}: a run needs --at X, and no --path")
    if args.edges is not None:
        raise exits.UsageError(f"{args.file}: a run keeps its mesh; give no --edges")
    with open_run(args.file) as run:
        scene = run.scene
        try:
            frame = run.frame_at(run.at(at, "end_shortening").index)
        except IndexError as error:
            raise exits.UsageError(f"--at = {args.at}: {error}") from error
    arc = arc_of(scene, args.control)
    slides = args.control == "end_tension" or (
        args.control != "end_shortening" and legs(scene)[int(frame.row["segment"])].slides
    )
    state = decode(arc.system, frame, slides=slides)
    if slides and args.control == "end_tension":
        arc.control.set(state, float(frame.row["end_tension"]) / arc.system.bending)
    settled = landed(arc, state, arc.control.value(state))
    if settled is None:
        raise exits.UsageError(f"{args.file}: the increment at {both(at)} does not settle again")
    return Start(scene, arc, through(arc, settled), slides)


def _from_branches(args: argparse.Namespace, at: float | None) -> Start:
    from derod.branches import open_branches
    from derod.tracing.starting import from_shape, landed, with_multipliers

    if at is None or args.path is None:
        raise exits.UsageError(f"{args.file}: a branch file needs --path NAME and --at X")
    with open_branches(args.file) as file:
        if args.path not in file:
            raise exits.UsageError(
                f"--path = {args.path}: is not in {args.file}; allowed: {', '.join(file.keys())}"
            )
        branch = file[args.path]
        scene = parse_scene(file.scene_text, path=args.file)
        delta = branch.table["end_shortening"]
        if not delta.min() <= at <= delta.max():
            low, high = both(float(delta.min())), both(float(delta.max()))
            raise exits.UsageError(f"--at = {args.at}: allowed on {args.path}: {low} to {high}")
        i = int(abs(delta - at).argmin())
        shape = (branch.arc_length(i), branch.positions(i), branch.drop_center(i))
        wetted = float(branch.table["wetted_length"][i])
        length = float(file.parameters.length)
    if args.edges is not None:
        scene = scene.replace({"mesh.edges": args.edges})
    arc = arc_of(scene, args.control)
    menisci = (0.5 * (length - wetted), 0.5 * (length + wetted))
    state = from_shape(arc.system, *shape, menisci)
    with_multipliers(arc.system, state)
    settled = landed(arc, state, arc.control.value(state))
    if settled is None:
        raise exits.UsageError(
            f"{args.file}: no state of {arc.system.edges} edges was found beside {args.path} at {both(at)}"
        )
    return Start(scene, arc, through(arc, settled), slides=False)
