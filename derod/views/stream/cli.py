"""``derod view``, and the options with which ``derod push`` is watched."""

from __future__ import annotations

import argparse
import time
from typing import TYPE_CHECKING, Any

from derod.errors import DerodError
from derod.pushing.interrupts import acknowledge
from derod.terminal import finish, say_done, show

if TYPE_CHECKING:
    from derod.pushing.frames import Observer
    from derod.scene import Scene

COLORS = ("curvature", "tension", "wall", "twist")


class ViewError(DerodError):
    """What cannot be watched or replayed."""


def add_push_options(parser: argparse.ArgumentParser) -> None:
    """``--rerun``, ``--color`` and ``--watch-relaxation``."""
    group = parser.add_argument_group("watching it in rerun")
    group.add_argument(
        "--rerun",
        metavar="WHERE",
        help="stream while it runs: spawn, connect[=URL], web or FILE.rrd",
    )
    _add_color(group)
    group.add_argument(
        "--watch-relaxation",
        metavar="WHICH",
        help="stream the relaxation's steps too: increments '57' or '57,58', or 'events' for "
        "those with a kick or a snap (timeline 'relaxation')",
    )


def _add_color(parser: Any) -> None:
    parser.add_argument(
        "--color",
        choices=COLORS,
        default="curvature",
        help="what the rod is coloured by (curvature); twist is uniform along an isotropic rod",
    )


def make_observers(args: argparse.Namespace, scene: Scene) -> list[Observer]:
    """The observers that the options ask for."""
    if args.rerun is None:
        if args.watch_relaxation is not None:
            raise ViewError("--watch-relaxation needs --rerun WHERE")
        return []
    from derod.files.outputs import check_output
    from derod.needs import check
    from derod.views.stream.observer import RelaxationWatch, RerunStream
    from derod.views.stream.target import parse_target

    target = parse_target(args.rerun, force=args.force, option="--rerun")
    check("rerun", "--rerun")
    if target.kind == "file":
        run = args.resume or args.output
        check_output(target.place, force=target.force, inputs=[args.scene], others=[run])
    stream = RerunStream(target, args.color)
    if args.watch_relaxation is None:
        return [stream]
    # the watch goes first: its last steps must be sent before the stream is closed
    return [RelaxationWatch(stream, parse_increments(args.watch_relaxation)), stream]


def parse_increments(text: str) -> frozenset[int] | None:
    """Increments from "57,58"; None from "events"."""
    if text == "events":
        return None
    try:
        numbers = frozenset(int(part) for part in text.split(","))
    except ValueError:
        numbers = frozenset([-1])
    if min(numbers) < 0:
        raise ViewError(
            f"--watch-relaxation = {text!r}: allowed: increments such as 57 or 57,58, or events"
        )
    return numbers


def add_view_parser(commands: Any) -> None:
    """``derod view FILE [--web | --save FILE.rrd | --connect URL]``."""
    parser = commands.add_parser(
        "view",
        help="replay a run or branch file in rerun",
        description="Replay a run file or a branch file in rerun's viewer.",
    )
    parser.add_argument("file", metavar="FILE", help="run file or branch file (HDF5)")
    where = parser.add_mutually_exclusive_group()
    where.add_argument(
        "--web", action="store_true", help="serve it to a browser on this machine until Ctrl-C"
    )
    where.add_argument("--save", metavar="FILE.rrd", help="write a rerun file instead")
    where.add_argument(
        "--connect",
        metavar="URL",
        nargs="?",
        const="",
        help="show it in a viewer that runs already",
    )
    parser.add_argument("--force", action="store_true", help="replace FILE.rrd if it exists")
    _add_color(parser)
    parser.set_defaults(command=run_view, writes=False)


def run_view(args: argparse.Namespace) -> int:
    """Carry out ``derod view``."""
    from derod.needs import need
    from derod.views import file_kinds as kinds
    from derod.views.stream.target import parse_target

    kinds.expect(args.file, kinds.RESULTS)
    need("rerun", "derod view")
    if args.web:
        target = parse_target("web")
    elif args.save is not None:
        from derod.files.outputs import check_output

        target = parse_target(args.save, force=args.force)
        if target.kind != "file":
            raise ViewError(f"--save = {args.save}: allowed: a name that ends in .rrd")
        check_output(target.place, force=args.force, inputs=[args.file])
    elif args.connect is not None:
        target = parse_target(f"connect={args.connect}" if args.connect else "connect")
    else:
        target = parse_target("spawn")
    from derod.views.stream.replay import replay_file
    from derod.views.stream.viewers import close_recording

    opened = replay_file(args.file, target, args.color)
    try:
        problem = close_recording(opened.recording, 60.0)
        if problem is not None:
            raise ViewError(problem)
        if opened.url is not None and opened.process is not None:
            show(f"{opened.url}\nserved on this machine only; Ctrl-C ends it")
            finish()
            wait_for(opened.process)
        elif target.kind == "file":
            say_done(f"{args.save}: written; open it with: rerun {args.save}")
    finally:
        if opened.url is not None and opened.process is not None:
            opened.process.terminate()
            opened.process.wait()
    return 0


def wait_for(process: Any) -> None:
    """Wait until the user has seen enough, or the server ends."""
    try:
        while process.poll() is None:
            time.sleep(0.2)
    except KeyboardInterrupt:
        acknowledge()
