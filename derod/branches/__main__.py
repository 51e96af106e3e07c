"""``python -m derod.branches branch|compare ...``: the two commands without the rest of derod."""

from __future__ import annotations

import argparse
import sys

from derod.branches.files.cli import add_branch_parser, add_compare_parser


def main() -> int:
    """Parse the command line and run it."""
    parser = argparse.ArgumentParser(prog="python -m derod.branches")
    subparsers = parser.add_subparsers(required=True)
    add_branch_parser(subparsers)
    add_compare_parser(subparsers)
    args = parser.parse_args()
    return int(args.command(args))


if __name__ == "__main__":
    sys.exit(main())
