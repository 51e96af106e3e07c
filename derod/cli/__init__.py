"""The command ``derod``: its parser, and what the exit codes mean.

Nothing heavy is imported here, so that ``derod --help`` answers at once; the commands import what
they need when they run.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from importlib import import_module
from typing import Any, NoReturn

from derod import __version__, terminal
from derod.errors import DerodError, RecordError, printable
from derod.exits import BAD_INPUT, DONE, MEANINGS, NOT_REACHED, NOT_SHOWN
from derod.files.outputs import RefusedError
from derod.pushing import interrupts

METHODS = ("implicit", "elliptic", "fire", "kinetic")

COMMANDS: tuple[str, ...] = (
    "derod.cli.scenes:add_scenes_parser",
    "derod.cli.scenes:add_init_parser",
    "derod.cli.branches:add_branch_parser",
    "derod.cli.branches:add_compare_parser",
    "derod.cli.modes:add_modes_parser",
    "derod.cli.modes:add_sensitivities_parser",
    "derod.cli.trace:add_trace_parser",
    "derod.cli.trace:add_explore_parser",
    "derod.cli.sweeps:add_sweep_parser",
    "derod.cli.fits:add_fit_parser",
    "derod.views.stream.cli:add_view_parser",
    "derod.views.plots.cli:add_plot_parser",
    "derod.views.plots.cli:add_movie_parser",
    "derod.views.export.cli:add_export_parser",
    "derod.cli.completion:add_completion_parser",
    "derod.cli.warmup:add_warmup_parser",
)
"""More commands, as "module:function"; the function is given the sub-parsers to add itself to."""

PUSH_WATCHERS: tuple[str, ...] = ("derod.views.stream.cli",)
"""Modules that add options to ``derod push`` and observers to the push.

Each has ``add_push_options(parser)`` and ``make_observers(args, scene) -> list[Observer]``.
"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit code (``exits.MEANINGS``)."""

    def work() -> int:
        parser = build_parser()
        args = parser.parse_args(arguments)
        if args.command is None:
            parser.print_help()
            return DONE
        try:
            return int(args.command(args))
        except RecordError as error:
            if isinstance(error, RefusedError) or not args.writes:
                raise
            terminal.say(f"derod: error: {error}")
            return NOT_REACHED

    return carry_out(work, leaving=arguments is None)


def carry_out(work: Callable[[], int], *, leaving: bool = True) -> int:
    """Do ``work`` and return its exit code; whatever goes wrong is one line and an exit code.

    ``leaving`` tells that the process ends afterwards.
    """
    terminal.keep_descriptors()
    with interrupts.signals(leaving=leaving):
        code = DONE
        try:
            code = work()
            terminal.finish()
            return code
        except terminal.NotShownError as error:
            terminal.say(f"derod: error: {error}")
            return code or NOT_SHOWN
        except DerodError as error:
            terminal.say(f"derod: error: {error}")
            return BAD_INPUT
        except SystemExit as stop:  # of argparse, after its own words
            return _after_words(stop)
        except KeyboardInterrupt:
            return _interrupted()
        except Exception:
            if interrupts.pending() is None:
                raise
            return _interrupted()  # it was swallowed on its way, and came back as something else


def _after_words(stop: SystemExit) -> int:
    """Let argparse end; help that cannot be printed is an error like any other."""
    try:
        terminal.finish()
    except terminal.NotShownError as error:
        terminal.say(f"derod: error: {error}")
        return NOT_SHOWN
    raise stop


def _interrupted() -> int:
    interrupts.acknowledge()
    terminal.say(f"derod: {interrupts.words()}")
    return interrupts.exit_code()


class Parser(argparse.ArgumentParser):
    """One whose complaints a terminal can show, and whose help must be shown."""

    def _print_message(self, message: str, file: Any = None) -> None:
        if message and (file is None or file is sys.stdout):
            terminal.show(message.removesuffix("\n"))
        else:
            super()._print_message(message, file)

    def error(self, message: str) -> NoReturn:
        """Print the usage and what is wrong, and exit with 2."""
        self.print_usage(sys.stderr)
        self.exit(BAD_INPUT, f"derod: error: {printable(message)}\n")


def build_parser() -> argparse.ArgumentParser:
    """The parser of all commands; ``args.command(args)`` runs the one that was given."""
    parser = Parser(
        prog="derod",
        description="Push an elastic rod into a liquid drop and watch it coil.",
        epilog=MEANINGS,
    )
    parser.add_argument("--version", action="version", version=f"derod {__version__}")
    parser.set_defaults(command=None, writes=False)
    commands = parser.add_subparsers(title="commands", metavar="COMMAND")
    _add_push(commands)
    _add_check(commands)
    _add_info(commands)
    for place in COMMANDS:
        module, _, function = place.partition(":")
        getattr(import_module(module), function)(commands)
    return parser


def _add_push(commands: Any) -> None:
    parser = commands.add_parser(
        "push",
        help="push the rod of a scene and record every settled increment",
        description="Push the rod of SCENE and record every settled increment in FILE. SCENE is a file, or "
        "the name of a scene that ships with derod (derod scenes).",
        epilog=MEANINGS,
    )
    parser.add_argument(
        "scene",
        nargs="?",
        metavar="SCENE",
        help="scene file (TOML), or a shipped one such as quick",
    )
    parser.add_argument(
        "-o",
        "--output",
        metavar="FILE",
        help="run file to write (SCENE.h5, beside SCENE; here for a shipped one)",
    )
    parser.add_argument("--force", action="store_true", help="replace files that exist")
    parser.add_argument("--resume", metavar="FILE", help="go on with a run that has ended")
    parser.add_argument("--method", metavar="M", help=f"relaxation: {', '.join(METHODS)}")
    parser.add_argument("--edges", type=int, metavar="N", help="edges of the discrete rod")
    parser.add_argument(
        "--stop",
        metavar="X",
        help="end-shortening to stop at, e.g. '2.8 pi', or in D: 8.8; or turning points '2 pi, 1 pi'",
    )
    parser.add_argument(
        "--extrapolate",
        action="store_true",
        help="push once more on half the edges: better values, and estimated errors",
    )
    _add_yes_really(parser)
    parser.add_argument("--quiet", action="store_true", help="show nothing but errors")
    for module in PUSH_WATCHERS:
        import_module(module).add_push_options(parser)
    parser.set_defaults(command=_run("push"), writes=True, watchers=PUSH_WATCHERS)


def _add_check(commands: Any) -> None:
    parser = commands.add_parser("check", help="check a scene and print its dimensionless groups")
    parser.add_argument("scene", metavar="SCENE", help="scene file (TOML), or a shipped one")
    _add_yes_really(parser)
    parser.set_defaults(command=_run("check"), writes=False)


def _add_yes_really(parser: Any) -> None:
    parser.add_argument(
        "--yes-really", action="store_true", help="also what plans 100 000 rows, or 20 GB, and more"
    )


def _add_info(commands: Any) -> None:
    parser = commands.add_parser(
        "info", help="say what a run did, or which branches a file has: landings, events, outcome"
    )
    parser.add_argument("file", metavar="FILE", help="run or branch file, finished or not")
    parser.add_argument(
        "--verify", action="store_true", help="read all of it back and check it (exit code 2)"
    )
    parser.add_argument(
        "--si", action="store_true", help="landings and ranges in SI too; needs [material]"
    )
    parser.set_defaults(command=_run("info"), writes=False)


def _run(name: str) -> Any:
    """The command ``name`` of ``derod.cli.commands``, imported when it is called."""
    return lambda args: getattr(import_module("derod.cli.commands"), name)(args)


if __name__ == "__main__":
    sys.exit(main())
