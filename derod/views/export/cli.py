"""``derod export``: arguments, messages and exit codes (0 written, 2 bad input)."""

from __future__ import annotations

import argparse
from typing import Any

from derod.exits import DONE


def add_export_parser(commands: Any) -> None:
    """``derod export FILE -o OUT.csv|OUT.pvd|OUT.h5md``."""
    parser = commands.add_parser(
        "export",
        help="write a run or branches for other programs: CSV, VTK, H5MD",
        description="Write a run file or a branch file as a CSV table, or a run as a time series of VTK "
        "files (ParaView): OUT.pvd, and a folder OUT beside it; or as an H5MD trajectory (MDAnalysis).",
    )
    parser.add_argument("file", metavar="FILE", help="run file, branch file or sweep")
    parser.add_argument(
        "-o",
        "--output",
        required=True,
        metavar="OUT",
        help="OUT.csv, or OUT.pvd, OUT.h5md of a run",
    )
    parser.add_argument("--force", action="store_true", help="replace OUT if it exists")
    parser.set_defaults(command=run_export, writes=False)


def run_export(args: argparse.Namespace) -> int:
    """Carry out ``derod export``."""
    from derod.views.export import export
    from derod.views.plots.reading import open_files

    with open_files([args.file]) as files:
        (file,) = (*files.runs, *files.branches, *files.sweeps)
        written = export(file, args.output, force=args.force)
    more = len(written) - 1
    print(written[0] if not more else f"{written[0]}, and {more} files in {written[1].parent}")
    return DONE
