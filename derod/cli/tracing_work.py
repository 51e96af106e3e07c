"""What ``derod trace`` and ``derod explore`` do."""

from __future__ import annotations

import argparse
import json
import math
import shlex
from typing import TYPE_CHECKING, Any

from derod import exits, scenes
from derod.errors import shown
from derod.files.outputs import check_output
from derod.scene import Scene
from derod.scene.controls import HELD
from derod.scene.quantities import read_quantity
from derod.terminal import say, say_done, show
from derod.views import file_kinds as kinds

if TYPE_CHECKING:
    from derod.diagram.content import Diagram
    from derod.tracing.arc import Arc
    from derod.tracing.path import Limits

MOST_POINTS, MOST_PATHS, MOST_MODES = 100_000, 1000, 20


def trace(args: argparse.Namespace) -> int:
    """``derod trace``."""
    from derod.cli.tracing_starts import begin

    _check_counts(args, mode=MOST_MODES)
    if args.control not in HELD:
        raise exits.UsageError(
            f"--control = {shown(args.control)}: is none; allowed: {', '.join(HELD)}"
        )
    kind = kinds.kind_of(scenes.file_of(args.file))
    kinds.expect(scenes.file_of(args.file), kinds.SCENES | kinds.RESULTS, "FILE")
    low, high = _range(args.to)
    at = None if args.at is None else _quantity("--at", args.at)
    output = args.output or _default(args.file, kind, "-trace.h5")
    check_output(output, force=args.force, inputs=[scenes.file_of(args.file)], make_folders=False)
    start = begin(args, kind, at)
    arc = start.arc
    limits = _limits(args, arc, low, high)
    diagram = _empty(start.scene, args, {"file": args.file, "at": args.at, "mode": args.mode})
    if not args.quiet:
        say(
            f"{args.file}: {start.scene.mesh.edges} edges, {HELD[args.control].words}; loading kernels"
        )
    from derod.tracing.explore import Bounds, Exploration

    found = Exploration(arc, Bounds(limits, MOST_PATHS), tell=_teller(args))
    first = start.follow(limits, "P1")
    found.add(first)
    if args.switch:
        for special in list(first.specials):
            if special.kind != "fold":
                found.switch(first, special)
    diagram.complete = True
    diagram.slides = start.slides
    _keep(arc, found.paths, diagram, output, overwrite=args.force)
    _tell_end(diagram, output, quiet=args.quiet)
    if not first.whole:
        say(f"derod: the path was not followed to an end of its own: {first.ends}")
        return exits.NOT_REACHED
    return exits.DONE


def explore(args: argparse.Namespace) -> int:
    """``derod explore``."""
    from derod.cli.tracing_starts import arc_of
    from derod.tracing.explore import Bounds, Exploration

    if args.resume is not None:
        return _resume(args)
    if args.scene is None:
        raise exits.UsageError("explore needs SCENE, a file or a shipped one, or --resume FILE")
    _check_counts(args, paths=MOST_PATHS, modes=MOST_MODES)
    if not (args.strong == 0 or 1 < args.strong <= 100):
        raise exits.UsageError(f"--strong = {args.strong:g}: allowed: 0, or above 1 and up to 100")
    kinds.expect(scenes.file_of(args.scene), kinds.SCENES, "SCENE")
    low, high = _range(args.to)
    if args.at is not None:
        _quantity("--at", args.at)
    output = args.output or _default(args.scene, kinds.Kind.SCENE, "-diagram.h5")
    ask = "--force replaces it, --resume goes on with it"
    check_output(
        output, force=args.force, inputs=[scenes.file_of(args.scene)], make_folders=False, ask=ask
    )
    arc = arc_of(_scene(args.scene, args.edges), "end_shortening")
    command = {name: getattr(args, name) for name in RESUMED}
    diagram = _empty(arc.system.scene, args, command)
    bounds = Bounds(
        _limits(args, arc, low, high), args.paths, args.modes, args.strong, modes=args.modes
    )
    found = Exploration(arc, bounds, tell=_teller(args))
    return _explore(args, found, diagram, output, overwrite=args.force)


RESUMED = ("to", "paths", "modes", "strong", "energy", "points")
"""Options of an exploration that its file keeps."""


def _resume(args: argparse.Namespace) -> int:
    from derod.cli.tracing_starts import arc_of
    from derod.diagram.reading import read_diagram
    from derod.diagram.restoring import restored
    from derod.errors import RecordError
    from derod.scene import parse_scene
    from derod.tracing.explore import Bounds, Exploration

    if args.scene is not None or args.output is not None:
        raise exits.UsageError("--resume FILE goes on in FILE: give no SCENE and no -o")
    kinds.expect(args.resume, kinds.DIAGRAMS, "--resume")
    check_output(args.resume, force=True)
    diagram = read_diagram(args.resume)
    told = json.loads(diagram.command)
    if not set(RESUMED) <= told.keys():
        raise RecordError(f"{args.resume}: is no exploration, and cannot be gone on with")
    asked = argparse.Namespace(**{**vars(args), **told})
    arc = arc_of(parse_scene(diagram.scene_text, path=args.resume), diagram.control)
    low, high = _range(asked.to)
    more = args.paths if args.paths > told["paths"] else told["paths"]
    bounds = Bounds(
        _limits(asked, arc, low, high), more, asked.modes, asked.strong, modes=asked.modes
    )
    found = Exploration(arc, bounds, tell=_teller(args))
    found.paths, found.stages = restored(arc, diagram), set(diagram.stages)
    return _explore(args, found, diagram, args.resume, overwrite=True)


def _explore(
    args: argparse.Namespace, found: Any, diagram: Diagram, output: str, *, overwrite: bool
) -> int:
    """Explore, keep every path as it is found, and say what there is."""
    written = [overwrite]

    def save() -> None:
        diagram.stages, diagram.complete = tuple(sorted(found.stages)), found.complete
        _keep(found.arc, found.paths, diagram, output, overwrite=written[0])
        written[0] = True

    found.save = save
    found.run()
    _tell_end(diagram, output, quiet=args.quiet)
    if args.at is not None:
        from derod.cli.diagram_summary import state_lines

        for line in state_lines(found.arc, found.paths, _quantity("--at", args.at)):
            show(line)
    if not found.complete:
        say(
            f"derod: {len(found.paths)} paths, and branch points are left; "
            f"derod explore --resume {shlex.quote(output)} --paths N goes on"
        )
        return exits.NOT_REACHED
    return exits.DONE


def _keep(arc: Arc, paths: list[Any], diagram: Diagram, output: str, *, overwrite: bool) -> None:
    from derod.diagram.content import stored
    from derod.diagram.writing import write_diagram

    unit = arc.system.bending**arc.control.power
    for path in paths:
        kept = diagram.paths.get(path.name)
        if kept is None:
            diagram.paths[path.name] = stored(arc.system, path, unit)
        else:
            from derod.diagram.content import special_table

            kept.specials = special_table(path, arc.system, unit)
    write_diagram(output, diagram, overwrite=overwrite)


def _empty(scene: Scene, args: argparse.Namespace, command: dict[str, Any]) -> Diagram:
    from derod.diagram.content import Diagram

    control = getattr(args, "control", "end_shortening")
    return Diagram(scene.text, control, json.dumps(command))


def _tell_end(diagram: Diagram, output: str, *, quiet: bool) -> None:
    if quiet:
        return
    from derod.cli.diagram_summary import diagram_lines

    for line in diagram_lines(diagram):
        show(line)
    say_done(f"next: derod info {shlex.quote(output)}, derod plot {shlex.quote(output)}")


def _teller(args: argparse.Namespace) -> Any:
    return (lambda line: None) if args.quiet else say


def _scene(place: str, edges: int | None) -> Scene:
    scene = scenes.read_scene(place)
    return scene if edges is None else scene.replace({"mesh.edges": edges})


def _default(file: str, kind: kinds.Kind, ending: str) -> str:
    if kind is kinds.Kind.SCENE:
        return kinds.default_output(file, ending)
    return file.removesuffix(".h5") + ending


def _limits(args: argparse.Namespace, arc: Arc, low: float, high: float) -> Limits:
    from derod.tracing.path import Limits

    unit = arc.system.bending**arc.control.power
    energy = math.inf if args.energy is None else args.energy / arc.system.bending
    return Limits(low / unit, high / unit, energy, args.points)


def _check_counts(args: argparse.Namespace, **most: int) -> None:
    for name, largest in {"points": MOST_POINTS, **most}.items():
        value = getattr(args, name)
        if not 1 <= value <= largest:
            raise exits.UsageError(f"--{name} = {value}: allowed: 1 to {largest}")
    if args.energy is not None and not 0 < args.energy < math.inf:
        raise exits.UsageError(f"--energy = {args.energy:g}: allowed: a number above 0")


def _quantity(option: str, text: str) -> float:
    try:
        return read_quantity(text)
    except ValueError as error:
        raise exits.UsageError(
            f"{option} = {shown(text)}: {error}; allowed: a number such as '1.5 pi' or 4.7"
        ) from None


def _range(text: str | None) -> tuple[float, float]:
    if text is None:
        return -math.inf, math.inf
    parts = text.split(",")
    if len(parts) != 2:
        raise exits.UsageError(f"--to = {shown(text)}: allowed: two numbers, e.g. '0, 2.5 pi'")
    low, high = (_quantity("--to", part) for part in parts)
    if not low < high:
        raise exits.UsageError(f"--to = {shown(text)}: allowed: two numbers, the lower one first")
    return low, high
