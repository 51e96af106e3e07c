"""``derod plot`` and ``derod movie``: arguments, messages and exit codes (0 made, 2 bad input)."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from derod.exits import DONE, UsageError, naming_options
from derod.views.file_kinds import Kind, expect, kind_of
from derod.views.plots.kinds import KINDS, need_matplotlib, read_places


def add_plot_parser(commands: Any) -> None:
    """``derod plot FILE [FILE ...] [--kind KIND]``."""
    parser = commands.add_parser(
        "plot",
        help="draw a picture of runs and branches",
        description="Draw a picture of run files and branch files, or of one diagram file. Kinds:\n"
        + "\n".join(f"  {name:11} {kind.shows} ({kind.wants})" for name, kind in KINDS.items()),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("files", nargs="+", metavar="FILE", help="run file, branch file or sweep")
    parser.add_argument("-k", "--kind", default="path", metavar="KIND", help="which picture (path)")
    parser.add_argument(
        "--at",
        default="",
        metavar="X,X",
        help="end-shortenings to show, e.g. '0.5 pi, 1 pi', or in D",
    )
    parser.add_argument(
        "--paths", default="", metavar="A,B", help="branches to draw, e.g. Ax,3D (all)"
    )
    parser.add_argument(
        "--keys", default="", metavar="X,Y", help="phase: the axes, e.g. rod.length,end_shortening"
    )
    parser.add_argument(
        "--every",
        type=int,
        default=1,
        metavar="N",
        help="compare, eigenvalues: every n-th increment (1)",
    )
    parser.add_argument(
        "--modes", type=int, default=3, metavar="N", help="modes, eigenvalues: how many (3)"
    )
    parser.add_argument(
        "-o", "--output", metavar="OUT", help=".png, .pdf or .svg (FILE-KIND.png, beside FILE)"
    )
    parser.add_argument("--force", action="store_true", help="replace OUT if it exists")
    parser.add_argument("--show", action="store_true", help="open a window; writes only with -o")
    parser.add_argument("--style", default="light", metavar="S", help="light or dark (light)")
    parser.add_argument("--dpi", type=int, default=160, help="of pixel pictures (160)")
    parser.set_defaults(command=run_plot, writes=False)


def run_plot(args: argparse.Namespace) -> int:
    """Carry out ``derod plot``."""
    from derod.views.export.output import check_target
    from derod.views.plots import ENDINGS, plot
    from derod.views.plots.reading import open_files

    if args.kind == "diagram" or kind_of(args.files[0]) is Kind.DIAGRAM:
        return plot_diagram(args)
    if args.kind not in KINDS:
        raise UsageError(f"--kind = {args.kind}: allowed: {', '.join(KINDS)}")
    first = Path(args.files[0])
    output = args.output
    if output is None and not args.show:
        output = str(first.with_name(f"{first.stem}-{args.kind}.png"))
    if output is not None:
        check_target(Path(output), args.force, ENDINGS)
    places = read_places(args.at, "--at") if args.at.strip() else ()
    need_matplotlib()
    with (
        naming_options("at", "paths", "keys", "every", "modes", "style", "dpi"),
        open_files(args.files) as files,
    ):
        plot(
            args.kind,
            [*files.runs, *files.branches, *files.sweeps],
            at=places,
            paths=[name.strip() for name in args.paths.split(",") if name.strip()],
            keys=[name.strip() for name in args.keys.split(",") if name.strip()],
            every=args.every,
            modes=args.modes,
            output=output,
            force=args.force,
            show=args.show,
            style=args.style,
            dpi=args.dpi,
        )
    if output is not None:
        print(output)
    return DONE


def plot_diagram(args: argparse.Namespace) -> int:
    """Draw a diagram file."""
    from derod.views.export.output import check_target
    from derod.views.plots.options import ENDINGS, read_options

    if args.kind not in ("path", "diagram") or len(args.files) > 1:
        raise UsageError("a diagram file is drawn by itself, and as --kind diagram")
    place = Path(args.files[0])
    expect(place, {Kind.DIAGRAM}, "--kind diagram")
    output = args.output or (None if args.show else f"{place.with_suffix('')}-diagram.png")
    if output is not None:
        check_target(Path(output), args.force, ENDINGS)
    with naming_options("style", "dpi"):
        _, sheet = read_options({"style": args.style, "dpi": args.dpi})
    need_matplotlib()
    from derod.diagram.reading import read_diagram
    from derod.views.plots.diagram import draw
    from derod.views.plots.picture import make_picture, show_window, write_picture
    from derod.views.plots.style import THEMES

    diagram, theme = read_diagram(place), THEMES[sheet.style]
    picture = make_picture(lambda figure: draw(figure, diagram, theme), theme, args.show)
    if output is not None:
        write_picture(picture, Path(output), theme, sheet.dpi, args.force)
        print(output)
    if args.show:
        show_window(picture)
    return DONE


def add_movie_parser(commands: Any) -> None:
    """``derod movie RUN -o OUT.gif``."""
    parser = commands.add_parser(
        "movie",
        help="paint a movie of a run",
        description="Paint the coil turning as it packs, and the curve t(delta) that leads there.",
    )
    parser.add_argument("file", metavar="RUN", help="run file (HDF5)")
    parser.add_argument(
        "-o", "--output", metavar="OUT", help=".gif, or .mp4 by ffmpeg (RUN-movie.gif, beside RUN)"
    )
    parser.add_argument("--force", action="store_true", help="replace OUT if it exists")
    parser.add_argument("--frames", type=int, default=120, metavar="N", help="pictures (120)")
    parser.add_argument("--rate", type=int, default=20, metavar="N", help="frames a second (20)")
    parser.add_argument("--width", type=int, default=640, metavar="N", help="pixels (640)")
    parser.add_argument("--style", default="dark", metavar="S", help="light or dark (dark)")
    parser.add_argument("--quiet", action="store_true", help="no progress")
    parser.set_defaults(command=run_movie, writes=False)


def run_movie(args: argparse.Namespace) -> int:
    """Carry out ``derod movie``."""
    from derod.record import open_run
    from derod.views import file_kinds as kinds

    need_matplotlib()
    kinds.expect(args.file, kinds.RUNS)
    first = Path(args.file)
    output = args.output or str(first.with_name(f"{first.stem}-movie.gif"))
    with naming_options("frames", "rate", "width", "style"), open_run(args.file) as run:
        from derod.views.plots.movie import movie

        movie(
            run,
            output,
            frames=args.frames,
            rate=args.rate,
            width=args.width,
            style=args.style,
            force=args.force,
            progress=not args.quiet,
        )
    print(output)
    return DONE
