"""``derod scenes`` and ``derod init``: something to run, and something to begin with."""

from __future__ import annotations

import argparse
import shlex
from typing import Any

from derod import exits, scenes
from derod.terminal import say_done, show


def add_scenes_parser(commands: Any) -> None:
    """``derod scenes [NAME]``."""
    parser = commands.add_parser(
        "scenes",
        help="list the scenes that ship with derod, or print one",
        description="List the scenes that ship with derod (derod push NAME runs one), or print one.",
    )
    parser.add_argument("name", nargs="?", metavar="NAME", help="print this scene's file")
    parser.set_defaults(command=run_scenes, writes=False)


def run_scenes(args: argparse.Namespace) -> int:
    """Carry out ``derod scenes``."""
    if args.name is not None:
        show(scenes.text(args.name).removesuffix("\n"))
        return exits.DONE
    width = max(len(name) for name in scenes.names())
    for name in scenes.names():
        show(f"{name:{width}}  {scenes.headline(name)}")
    show("\nderod push quick          runs one; its results go to quick.h5, here")
    show("derod scenes quick        prints its file")
    show("derod init my.toml        writes a commented scene to change")
    return exits.DONE


def add_init_parser(commands: Any) -> None:
    """``derod init FILE [--like NAME]``."""
    parser = commands.add_parser(
        "init",
        help="write a commented scene to begin with",
        description="Write a scene with all its keys, their values and what they mean; or a copy of a "
        "scene that ships with derod.",
    )
    parser.add_argument("file", metavar="FILE", help="scene file to write, such as my.toml")
    parser.add_argument("--like", metavar="NAME", help="copy this shipped scene (derod scenes)")
    parser.add_argument("--force", action="store_true", help="replace FILE if it exists")
    parser.set_defaults(command=run_init, writes=False)


def run_init(args: argparse.Namespace) -> int:
    """Carry out ``derod init``."""
    from derod.files.outputs import replacing

    if not args.file.endswith(scenes.ENDING):
        raise exits.UsageError(f"{args.file}: allowed: a name that ends in {scenes.ENDING}")
    name = scenes.NEW if args.like is None else args.like
    text = scenes.text(name).replace("THIS_FILE", shlex.quote(args.file))
    with replacing(args.file, force=args.force) as passing:
        passing.write_text(text, encoding="utf-8")
    file = shlex.quote(args.file)
    say_done(f"{args.file}: written; next: derod check {file}, derod push {file}")
    return exits.DONE
