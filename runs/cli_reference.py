"""Write the reference of the command line, docs/cli.md, from the commands themselves.

python runs/cli_reference.py            # writes it
python runs/cli_reference.py --check    # exit code 1 where the page is not what the commands say
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from pages import write_or_check

from derod.cli import build_parser

PAGE = Path(__file__).parents[1] / "docs" / "cli.md"
HEAD = """# The command line

`derod COMMAND --help` prints this. Exit codes: 0 done; 1 a comparison or a verification failed; 2 bad input;
3 the push did not get to its end; 4 results could not be shown; 128 + n ended by signal n. This page is
written by `python runs/cli_reference.py`.
"""


def row(action: argparse.Action, command: str) -> str:
    """One argument as a row of a table."""
    named = action.metavar if isinstance(action.metavar, str) else action.dest
    text = (action.help or "").replace("%(default)s", str(action.default))
    text = text.replace("%(prog)s", f"derod {command}").replace("%%", "%").replace("|", "\\|")
    return f"| `{', '.join(action.option_strings) or named}` | {' '.join(text.split())} |"


def page() -> str:
    """The whole page."""
    parser = build_parser()
    commands = next(a for a in parser._actions if isinstance(a, argparse._SubParsersAction))
    said = {choice.dest: choice.help or "" for choice in commands._choices_actions}
    lines = [HEAD]
    for name, command in commands.choices.items():
        words = said.get(name, "").strip().rstrip(".")
        lines += [f"## derod {name}", "", f"{words[:1].upper()}{words[1:]}.", ""]
        shown = [a for a in command._actions if not isinstance(a, argparse._HelpAction)]
        if shown:
            lines += ["| argument | |", "|---|---|", *(row(a, name) for a in shown), ""]
    return "\n".join(lines)


if __name__ == "__main__":
    sys.exit(write_or_check(PAGE, page, (__doc__ or "").splitlines()[0]))
