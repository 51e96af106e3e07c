"""``derod compare``: the comparison as text, and as an exit code."""

from __future__ import annotations

import argparse

import numpy as np

from derod.branches.files.compare import ERRORS, compare, worst
from derod.branches.files.record import open_branches
from derod.errors import DerodError, RecordError

NOT_SHOWN = 4  # the exit code of results that cannot be printed


def report(result: np.ndarray, quiet: bool) -> str:
    """The comparison as text: one line a row (unless quiet), then the worst of each error."""
    lines = []
    if not quiet:
        lines.append("  row  delta/pi  branch       t error    E_hat error  wetted [D]   shape [D]")
        for r in result:
            name = r["branch"] or "on no branch"
            numbers = "".join(f"  {r[key]:11.2e}" for key in ERRORS)
            lines.append(f"{r['row']:5d}  {r['end_shortening'] / np.pi:8.5f}  {name:12s}{numbers}")
    for name, (value, at) in worst(result).items():
        lines.append(
            f"worst {name.replace('_', ' '):15s} {value:9.2e}  at delta = {at / np.pi:.5f} pi"
        )
    off = result[result["branch"] == ""]
    lines.append(f"{len(result) - len(off)} of {len(result)} rows lie on a branch")
    if len(off):
        span = off["end_shortening"] / np.pi
        lines.append(
            f"on no branch: {len(off)} rows between {span.min():.5f} pi and {span.max():.5f} pi"
        )
    return "\n".join(lines)


def exceeds(result: np.ndarray, tolerance: float) -> bool:
    """Whether t or E_hat is off by more than ``tolerance``, lengths by more than twice that, or a
    row by a branch. What is not a number is off."""
    limits = dict(zip(ERRORS, (tolerance, tolerance, 2 * tolerance, 2 * tolerance), strict=True))
    if np.any(result["branch"] == ""):
        return True
    return any(np.any(~(result[name] <= limit)) for name, limit in limits.items())


def compare_files(args: argparse.Namespace) -> int:
    """Carry out ``derod compare``: 0 within tolerance, 1 beyond it, 2 bad input.

    A run without rows, and branches without points, cannot be compared: that is bad input. Both files
    are held against their checksums.
    """
    import derod
    from derod import terminal

    if not args.tolerance > 0.0 or args.every < 1:
        terminal.say("derod: error: --tolerance and --every must be positive")
        return 2
    try:
        with derod.open_run(args.run) as run, open_branches(args.branches) as file:
            if run.checksummed:
                run.verify()
            if not len(run):
                raise RecordError(f"{args.run}: has no rows that could be compared")
            if not sum(len(branch) for branch in file.values()):
                raise RecordError(f"{args.branches}: has no branches to compare with")
            if not file.complete:
                terminal.say(
                    f"derod: {args.branches}: is not complete (derod branch --resume goes on)"
                )
            result = compare(run, file, args.every)
    except DerodError as error:
        terminal.say(f"derod: error: {error}")
        return 2
    code = 1 if exceeds(result, args.tolerance) else 0
    try:
        terminal.show(report(result, args.quiet))
        terminal.finish()
    except terminal.NotShownError as error:
        terminal.say(f"derod: error: {error}")
        return code or NOT_SHOWN
    return code
