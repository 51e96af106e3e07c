"""``derod branch`` and ``derod compare`` as the command line offers them.

Their work is that of ``derod.branches.cli``; here scenes may be shipped ones, the output has a default name,
and files are looked at before they are read.
"""

from __future__ import annotations

import argparse
import shlex
from typing import Any

from derod import exits, scenes
from derod.terminal import say_done
from derod.views import file_kinds as kinds


def add_branch_parser(commands: Any) -> None:
    """``derod branch SCENE [-o FILE]``."""
    from derod.branches.files import cli

    parser = cli.add_branch_parser(commands)
    for action in parser._actions:
        if action.dest == "output":
            action.metavar = "FILE"
            action.help = (
                "branch file to write (SCENE-branches.h5, beside SCENE), or the text exported"
            )
        if action.dest == "scene":
            action.help = (
                "scene file (TOML), or the name of a shipped one; a branch file with --export"
            )
    parser.set_defaults(command=run_branch)


def run_branch(args: argparse.Namespace) -> int:
    """Carry out ``derod branch``."""
    from derod.branches.files import cli

    if args.resume is not None:
        kinds.expect(args.resume, kinds.BRANCHES, "--resume")
    elif args.export is not None:
        if args.scene is not None:
            kinds.expect(args.scene, kinds.BRANCHES, "--export")
    elif args.scene is not None:
        kinds.expect(scenes.file_of(args.scene), kinds.SCENES, "SCENE")
        scenes.read_scene(args.scene)  # says what was meant, where there is none
        if args.output is None:
            args.output = kinds.default_output(args.scene, "-branches.h5")
        args.scene = scenes.file_of(args.scene)
    code = cli.run_branch(args)
    if code == exits.DONE and not args.quiet and args.export is None:
        file = shlex.quote(args.resume or args.output)
        say_done(f"next: derod info {file}, derod plot {file}, derod view {file}")
    return code


def add_compare_parser(commands: Any) -> None:
    """``derod compare RUN BRANCHES``."""
    from derod.branches.files import cli

    parser = cli.add_compare_parser(commands)
    parser.set_defaults(command=run_compare)


def run_compare(args: argparse.Namespace) -> int:
    """Carry out ``derod compare``."""
    from derod.branches.files import cli

    kinds.expect(args.run, kinds.RUNS, "RUN, the first file")
    kinds.expect(args.branches, kinds.BRANCHES, "BRANCHES, the second file")
    return cli.run_compare(args)
