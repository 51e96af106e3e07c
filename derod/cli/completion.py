"""``derod completion``: the words of the command line, for shells that complete them."""

from __future__ import annotations

import argparse
from typing import Any

from derod import exits
from derod.terminal import show

SHELLS = ("bash", "zsh")
FILES = ("FILE", "RUN", "SCENE", "BRANCHES", "OUT", "FILE.rrd", "RUN.h5")
"""Words of the help that stand for files."""
HOW = {
    "bash": "derod completion bash > ~/.local/share/bash-completion/completions/derod",
    "zsh": "derod completion zsh > ~/.zfunc/_derod   (with fpath+=~/.zfunc before compinit)",
}


def add_completion_parser(commands: Any) -> None:
    """``derod completion bash|zsh``."""
    parser = commands.add_parser(
        "completion",
        help="print what completes derod's commands in bash or zsh",
        description="Print a script that completes derod's commands and options:\n"
        + "\n".join(f"  {how}" for how in HOW.values()),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("shell", choices=SHELLS, help="for which shell")
    parser.set_defaults(command=run_completion, writes=False)


def run_completion(args: argparse.Namespace) -> int:
    """Carry out ``derod completion``."""
    try:
        import shtab
    except ImportError:
        raise exits.UsageError(
            "completion needs shtab, which is not installed: pip install shtab"
        ) from None
    from derod.cli import build_parser

    parser = build_parser()
    _mark_files(parser, shtab.FILE)
    show(shtab.complete(parser, args.shell).removesuffix("\n"))
    return exits.DONE


def _mark_files(parser: argparse.ArgumentParser, files: Any) -> None:
    """Say of every argument that is a file that files complete it."""
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for command in action.choices.values():
                _mark_files(command, files)
        elif action.metavar in FILES or action.dest in ("scene", "run", "branches", "output"):
            action.complete = files  # type: ignore[attr-defined]
