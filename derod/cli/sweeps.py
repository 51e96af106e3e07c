"""``derod sweep``: many pushes, on this machine or on a cluster."""

from __future__ import annotations

import argparse
import shlex
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from derod import exits
from derod.terminal import say, say_done, show
from derod.views import file_kinds as kinds

if TYPE_CHECKING:
    from derod.sweeps.files import Sweep
    from derod.sweeps.plan import Plan
    from derod.sweeps.running import Tally

MOST_NAMED = 10


def add_sweep_parser(commands: Any) -> None:
    """``derod sweep SWEEP.toml [-o FILE]``."""
    parser = commands.add_parser(
        "sweep",
        help="push a scene at many values of its keys, and record them in one table",
        description="Push the scene of SWEEP at every point of a grid, a list or a sample of its keys, and "
        "write one table of all of them. Points that fail are listed (exit code 3), and a sweep that was "
        "stopped goes on with --resume.",
    )
    parser.add_argument("sweep", nargs="?", metavar="SWEEP", help="sweep file (TOML)")
    parser.add_argument(
        "-o", "--output", metavar="FILE", help="sweep file to write (SWEEP.h5, beside SWEEP)"
    )
    parser.add_argument("--force", action="store_true", help="replace FILE, and begin anew")
    parser.add_argument("--resume", metavar="FILE", help="go on with a sweep that was stopped")
    parser.add_argument(
        "--workers", type=int, metavar="N", help="processes on this machine (one a core)"
    )
    parser.add_argument(
        "--scheduler", metavar="ADDRESS", help="a Dask cluster that is there, e.g. tcp://host:8786"
    )
    parser.add_argument(
        "--keep-runs", metavar="FOLDER", help="keep the full run of every point, FOLDER/POINT.h5"
    )
    parser.add_argument("--quiet", action="store_true", help="show nothing but errors")
    parser.set_defaults(command=run_sweep, writes=True)


def run_sweep(args: argparse.Namespace) -> int:
    """Carry out ``derod sweep``."""
    plan, path = _what(args)
    from derod.sweeps.engines import workers_or_default
    from derod.sweeps.files import Sweep
    from derod.sweeps.running import Means, check_target
    from derod.sweeps.running import run_sweep as run
    from derod.views.sweep_progress import SweepProgress

    if plan is not None:
        check_target(Path(path), overwrite=args.force)
    with SweepProgress() as progress:
        remark = (lambda line: None) if args.quiet else progress.say
        means = Means(
            workers=workers_or_default(args.workers, args.scheduler, remark),
            scheduler=args.scheduler,
            runs=_folder(args.keep_runs),
            say=remark,
        )
        if plan is not None:
            if not args.quiet:
                _say_first(args, plan, means)
            _compile(plan, args)
        tally = run(
            plan, Path(path), means, overwrite=args.force,
            watch=(lambda tally: None) if args.quiet else progress,
        )  # fmt: skip
    with Sweep(path) as sweep:
        return _end(sweep, tally, path, quiet=args.quiet)


def _what(args: argparse.Namespace) -> tuple[Plan | None, str]:
    """The plan of a sweep that begins, None of one that goes on; and its file."""
    if args.workers is not None and args.workers < 1:
        raise exits.UsageError(f"--workers = {args.workers}: allowed: 1, 2, 3, ...")
    if args.workers is not None and args.scheduler is not None:
        raise exits.UsageError("--workers is for this machine, --scheduler has workers: give one")
    if args.resume:
        if args.sweep or args.output or args.force:
            raise exits.UsageError(
                "--resume FILE goes on in FILE: give no SWEEP, no -o, no --force"
            )
        return None, args.resume
    if not args.sweep:
        raise exits.UsageError("sweep needs SWEEP, a file (docs/sweeps.md), or --resume FILE")
    from derod.sweeps.plan import read_plan

    kinds.expect(args.sweep, kinds.SWEEPS, "SWEEP")
    plan = read_plan(args.sweep)
    return plan, args.output or kinds.default_output(args.sweep, ".h5")


def _folder(name: str | None) -> str | None:
    if name is None:
        return None
    folder = Path(name)
    if folder.exists() and not folder.is_dir():
        raise exits.UsageError(f"--keep-runs = {name}: is no folder")
    return str(folder.resolve())


def _say_first(args: argparse.Namespace, plan: Plan, means: Any) -> None:
    where = f"on {args.scheduler}" if args.scheduler else f"in {means.workers} processes"
    if means.workers == 1 and not args.scheduler:
        where = "in this process"
    say(
        f"{args.sweep}: {plan.count} points over {', '.join(plan.keys)} ({plan.design}), {where}; "
        "loading kernels"
    )


def _compile(plan: Plan, args: argparse.Namespace) -> None:
    """Have the kernels compiled here once, with words, before workers look for them."""
    from derod.cli.compiling import kernels_ready
    from derod.errors import SceneError

    if args.scheduler is not None:
        return
    scene = plan.scene
    for values in plan.points():
        try:
            scene = plan.scene.replace(plan.changes(values))
            break
        except SceneError:  # told as that point's outcome
            continue
    with kernels_ready(scene, quiet=args.quiet):
        return


def _end(sweep: Sweep, tally: Tally, path: str, *, quiet: bool) -> int:
    """Say what came out; the exit code."""
    file = shlex.quote(path)
    count = f"{len(sweep)} points"
    words = f"{count}, {len(sweep.rows)} rows in {path}"
    if tally.done:
        words += f"; the pushes took {tally.seconds:.3g} s of CPU time"
    if tally.failed:
        say(f"derod: {tally.failed} of {count} did not complete; {words}")
        for line in failure_lines(sweep):
            say(f"derod: {line}")
        return exits.NOT_REACHED
    if not quiet:
        say_done(words)
        say_done(
            f"next: derod info {file}, derod plot {file} -k phase, derod export {file} -o rows.csv"
        )
    return exits.DONE


def failure_lines(sweep: Sweep) -> Iterator[str]:
    """The points that did not complete: a line each, up to ``MOST_NAMED``."""
    from derod.errors import printable

    failures = sweep.failures()
    for row in failures[:MOST_NAMED]:
        values = ", ".join(f"{key} = {shown(row[key])}" for key in sweep.keys)
        message = printable(row["message"].decode("utf-8", "replace"), 200)
        outcome = row["outcome"].decode().replace("_", " ")
        yield f"point {row['point']} ({values}): {outcome}" + (f": {message}" if message else "")
    if len(failures) > MOST_NAMED:
        yield f"and {len(failures) - MOST_NAMED} more (derod.open_sweep(FILE).failures())"


def sweep_lines(sweep: Sweep) -> Iterator[str]:
    """What ``derod info`` says of a sweep."""
    from collections import Counter

    plan = sweep.plan
    state = "complete" if sweep.complete else "not complete (derod sweep --resume goes on with it)"
    yield f"{sweep.path}: a sweep of {len(sweep)} points ({plan.design}), {state}"
    for key in sweep.keys:
        column = sweep.outcomes[key]
        if column.dtype.kind in "if":
            yield f"  {key:28}{column.min():.6g} to {column.max():.6g}"
        else:
            yield f"  {key:28}{', '.join(sorted({shown(x) for x in column}))}"
    yield f"  {'rows':28}{len(sweep.rows)} ({plan.rows} of each push)"
    for outcome, count in Counter(sweep.outcomes["outcome"].tolist()).most_common():
        yield f"  {outcome.decode().replace('_', ' '):28}{count}"
    yield from failure_lines(sweep)


def shown(value: Any) -> str:
    """A key's value, readably."""
    value = value.item()
    return (
        value.decode()
        if isinstance(value, bytes)
        else f"{value:.6g}"
        if isinstance(value, float)
        else str(value)
    )


def show_info(args: argparse.Namespace) -> int:
    """``derod info`` of a sweep."""
    from derod.sweeps.files import Sweep

    if args.si:
        raise exits.UsageError(f"{args.file}: --si is for run files, and this is a sweep")
    with Sweep(args.file) as sweep:  # reading holds all of it against its checksums
        for line in sweep_lines(sweep):
            show(line)
        if args.verify:
            show(
                f"verified: all {len(sweep)} points and {len(sweep.rows)} rows fit their checksums"
            )
    return exits.DONE
