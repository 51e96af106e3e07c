"""``derod modes`` and ``derod sensitivities``: what a recorded state does when it is disturbed."""

from __future__ import annotations

import argparse
import math
from typing import TYPE_CHECKING, Any

from derod import exits
from derod.errors import printable
from derod.terminal import say, say_done, show
from derod.views import file_kinds as kinds

if TYPE_CHECKING:
    from derod.record.kicked import Kicked
    from derod.record.modes import Modes
    from derod.record.run import BaseRun
    from derod.record.sensitivities import Sensitivities


def add_modes_parser(commands: Any) -> None:
    """``derod modes RUN --at X [--count K]``."""
    parser = commands.add_parser(
        "modes",
        help="the softest modes of recorded states: eigenvalues, symmetries, where a kick leads",
        description="Print the lowest eigenvalues of the Hessian on the constraints at recorded states, and "
        "how their modes stand to the state's symmetries. Draw them, stream them, keep them in a file; or "
        "kick a state along one and say where it goes.",
        epilog=exits.MEANINGS,
    )
    add_places(parser)
    parser.add_argument("--count", type=int, default=6, metavar="K", help="how many modes (6)")
    parser.add_argument(
        "--kick", type=int, metavar="M", help="kick along mode M of the table, 1 ..."
    )
    parser.add_argument(
        "--amplitude", type=float, default=0.05, metavar="A",
        help="of the kick, the largest displacement in D; either sign (0.05)",
    )  # fmt: skip
    parser.add_argument("--plot", metavar="OUT", help="draw them: .png, .pdf or .svg")
    parser.add_argument(
        "--rerun", metavar="WHERE", help="stream them: spawn, connect[=URL] or FILE.rrd"
    )
    parser.set_defaults(command=run_modes, writes=False)


def add_sensitivities_parser(commands: Any) -> None:
    """``derod sensitivities RUN --at X``."""
    parser = commands.add_parser(
        "sensitivities",
        help="how recorded states change with every parameter of the scene",
        description="Print the derivatives of t, E_hat and the menisci's places by every parameter of the "
        "scene at recorded states; with -o keep them with those of the shape.",
        epilog=exits.MEANINGS,
    )
    add_places(parser)
    parser.set_defaults(command=run_sensitivities, writes=False)


def add_places(parser: argparse.ArgumentParser) -> None:
    """The run, the states in it, and the file to keep answers in."""
    parser.add_argument("file", metavar="RUN", help="run file (HDF5)")
    parser.add_argument(
        "--at", default="", metavar="X,X",
        help="end-shortenings, e.g. '0.5 pi, 1 pi', or in D; values of what pushes (the last increment)",
    )  # fmt: skip
    parser.add_argument("-o", "--output", metavar="FILE", help="keep them in FILE (HDF5)")
    parser.add_argument("--force", action="store_true", help="replace files that exist")


def increments(run: BaseRun, at: str) -> list[int]:
    """The increments nearest to what ``--at`` asks for; the last one where it asks for nothing."""
    if not len(run):
        raise exits.UsageError(f"{run.path}: the run has no increment")
    if not at.strip():
        return [len(run) - 1]
    try:
        return list(dict.fromkeys(run.at(part.strip()).index for part in at.split(",")))
    except (ValueError, IndexError) as error:
        raise exits.UsageError(f"--{error}") from None


def run_modes(args: argparse.Namespace) -> int:
    """Carry out ``derod modes``."""
    from derod.equilibrium.eigen import NotConvergedError
    from derod.record import open_run

    kinds.expect(args.file, kinds.RUNS)
    check_modes(args)
    with open_run(args.file) as run:
        places = increments(run, args.at)
        found, kicks = {}, {}
        code = exits.DONE
        for i in places:
            try:
                found[i] = run.modes(i, args.count)
            except NotConvergedError as error:
                say(f"derod: {error}")
                code = exits.NOT_REACHED
                continue
            for line in mode_lines(run, i, found[i]):
                show(line)
            if args.kick is not None:
                kicks[i] = run.kick(i, args.kick - 1, args.amplitude, found[i])
                for line in kick_lines(args.kick, args.amplitude, kicks[i]):
                    show(line)
                if not kicks[i].converged:
                    code = exits.NOT_REACHED
        if found:
            keep(args, run, found, kicks)
    return code


def check_modes(args: argparse.Namespace) -> None:
    """Refuse what makes no sense before any work."""
    from derod.views.export.output import check_target
    from derod.views.plots.options import ENDINGS

    check_output_of(args)
    if args.count < 1:
        raise exits.UsageError(f"--count = {args.count}: allowed: 1, 2, 3, ...")
    if args.kick is not None and not 1 <= args.kick <= args.count:
        raise exits.UsageError(f"--kick = {args.kick}: allowed: 1 to {args.count}, as --count says")
    if args.kick is not None and not (math.isfinite(args.amplitude) and args.amplitude != 0):
        raise exits.UsageError(f"--amplitude = {args.amplitude:g}: allowed: a length in D, not 0")
    if args.plot is not None:
        from pathlib import Path

        check_target(Path(args.plot), args.force, ENDINGS, "--plot")
    if args.rerun is not None:
        from derod.needs import need
        from derod.views.stream.target import TargetError, parse_target

        need("rerun", "--rerun")
        target = parse_target(args.rerun, force=args.force, option="--rerun")
        if target.kind == "web":
            raise TargetError("--rerun = web: allowed: spawn, connect[=URL] or FILE.rrd")


def check_output_of(args: argparse.Namespace) -> None:
    """Refuse a file that must not be written."""
    if args.output is not None:
        from derod.files.outputs import check_output

        check_output(args.output, force=args.force, inputs=[args.file])


def keep(
    args: argparse.Namespace, run: BaseRun, found: dict[int, Any], kicks: dict[int, Any]
) -> None:
    """Draw, stream and write what was asked for."""
    if args.plot is not None:
        from derod.views.plots import plot

        column = run.table["end_shortening"]
        places = [float(column[i]) for i in found]
        plot("modes", [run], at=places, modes=args.count, output=args.plot, force=args.force)
        say_done(f"{args.plot}: drawn")
    if args.rerun is not None:
        stream(args, run, found)
    if args.output is not None:
        from derod.record.answers import write_answers

        write_answers(args.output, run, found, kicks, force=args.force)
        say_done(f"{args.output}: written")


def stream(args: argparse.Namespace, run: BaseRun, found: dict[int, Any]) -> None:
    """Send the modes of the first state to rerun."""
    from derod.views.stream.cli import ViewError
    from derod.views.stream.modes import send_modes
    from derod.views.stream.target import parse_target
    from derod.views.stream.viewers import close_recording, drop_recording, open_recording

    target = parse_target(args.rerun, force=args.force, option="--rerun")
    opened = open_recording(target, f"modes of {args.file}")
    try:
        first = next(iter(found))
        send_modes(opened.recording, run, first, found[first], "curvature")
    except BaseException:
        drop_recording(opened.recording)
        raise
    problem = close_recording(opened.recording, 60.0)
    if problem is not None:
        raise ViewError(problem)
    if target.kind == "file":
        say_done(f"{args.rerun}: written; open it with: rerun {args.rerun}")


def head_line(run: BaseRun, i: int) -> str:
    """Which state this is."""
    return printable(repr(run[i])[1:-1])


def mode_lines(run: BaseRun, i: int, found: Modes) -> list[str]:
    """The table of an increment's modes."""
    lines = [
        head_line(run, i),
        f"  {'mode':>4}  {'eigenvalue/(K0/D^4)':>20}  {'':8}  {'flip':5}  plane",
    ]
    for k, value in enumerate(found.eigenvalues):
        word = "unstable" if value < 0 else "stable"
        flip, plane = found.flip[k] or "-", found.plane[k] or "-"
        lines.append(f"  {k + 1:>4}  {value:>20.8g}  {word:8}  {flip:5}  {plane}")
    turn = "neutral, left out" if found.turns_freely else "not neutral: among the modes above"
    lines.append(f"  turning about the clamps' axis: {turn}")
    if math.isfinite(found.sliding_stiffness):
        lines.append(
            f"  sliding of the drop along the rod: held, left out; its stiffness is "
            f"{found.sliding_stiffness:.3g} K0/D^3"
        )
    return lines


def kick_lines(mode: int, asked: float, kick: Kicked) -> list[str]:
    """Where a kick led."""
    halved = "" if kick.amplitude == asked else f" (halved from {asked:g} D: the wall is near)"
    count = int(kick.frame.row["unstable_modes"])
    if not kick.converged:
        end = f"not settled: {kick.message}"
    elif kick.came_back:
        end = "back to the state it came from"
    else:
        words = "stable" if count == 0 else f"{count} unstable mode{'s' * (count > 1)}"
        end = (
            f"to another state, {kick.moved:.4g} D away: t = {kick.frame.row['end_tension']:.6g} K0/D^2, "
            f"E_hat = {kick.frame.row['energy_hat']:.6g} K0/D, {words}"
        )
    return [
        f"  kicked along mode {mode} by {kick.amplitude:g} D{halved}: energy {kick.energy_before:.8g} -> "
        f"{kick.energy_kicked:.8g} K0/D, then down to {kick.energy_after:.8g}",
        f"  {end}",
    ]


def run_sensitivities(args: argparse.Namespace) -> int:
    """Carry out ``derod sensitivities``."""
    from derod.equilibrium.eigen import NotConvergedError
    from derod.record import open_run
    from derod.record.answers import write_answers

    kinds.expect(args.file, kinds.RUNS)
    check_output_of(args)
    with open_run(args.file) as run:
        found = {}
        for i in increments(run, args.at):
            try:
                found[i] = run.sensitivities(i)
            except NotConvergedError as error:
                say(f"derod: increment {i}: {error}")
                return exits.NOT_REACHED
            for line in sensitivity_lines(run, i, found[i]):
                show(line)
        if args.output is not None:
            write_answers(args.output, run, found, force=args.force)
            say_done(f"{args.output}: written")
    return exits.DONE


def sensitivity_lines(run: BaseRun, i: int, found: Sensitivities) -> list[str]:
    """The table of an increment's derivatives."""
    lines = [
        head_line(run, i),
        f"  {'parameter p':16}{'value':>13}{'dt/dp':>15}{'dE_hat/dp':>15}{'ds_A/dp':>15}{'ds_B/dp':>15}",
    ]
    for k, name in enumerate(found.parameters):
        text = f"  {name:16}{found.values[k]:>13.6g}"
        if found.unbounded[k]:
            lines.append(f"{text}{'unbounded: the state is at a fold, or turns at once':>52}")
            continue
        numbers = (found.end_tension[k], found.energy_hat[k], *found.menisci[k])
        lines.append(text + "".join(f"{number:>15.7g}" for number in numbers))
    lines.append(f"  the softest mode's eigenvalue: {found.eigenvalue:.6g} K0/D^4")
    return lines
