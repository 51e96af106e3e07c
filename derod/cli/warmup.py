"""``derod warmup``: compile before it is needed, for images of machines and for clusters."""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Iterable
from functools import partial
from typing import TYPE_CHECKING, Any

from derod import exits
from derod.terminal import say, show

if TYPE_CHECKING:
    from derod.algebra.survey import Wanted
    from derod.pushing.exercise import Variant


def add_warmup_parser(subparsers: Any) -> argparse.ArgumentParser:
    """Add ``derod warmup`` to the commands."""
    parser: argparse.ArgumentParser = subparsers.add_parser(
        "warmup",
        help="compile kernels into the cache before they are needed",
        description=(
            "Compile the kernels that pushes of the SCENEs need, folds and unstable states included, or "
            "without SCENE those of all pushes and of branches, into the user's cache."
        ),
        epilog=exits.MEANINGS,
    )
    parser.add_argument("scenes", nargs="*", metavar="SCENE", help="scene files (TOML)")
    parser.add_argument("--quiet", action="store_true", help="show nothing but errors")
    parser.set_defaults(command=warmup, writes=False)
    return parser


def warmup(args: argparse.Namespace) -> int:
    """Compile what is missing; exit code 3 where it cannot be kept."""
    if not args.quiet:
        say("warmup: looking which kernels are missing")
    variants = asked_for(args.scenes)
    from derod.algebra import compiling

    began = time.monotonic()
    wanted = kernels_of(variants)
    compile_missing(wanted, branches=not args.scenes, quiet=args.quiet)
    lost = sorted({one.name for one in wanted if not one.is_kept()})
    folder = cache_folder()
    if folder is None or lost:
        what = f"{len(lost)} kernels ({', '.join(lost)})" if lost else "the kernels"
        say(f"derod: {what} cannot be kept: no cache folder that lasts and that only we may write")
        return exits.NOT_REACHED
    note_all_ready(variants)
    if not args.quiet:
        show(
            f"{len(wanted)} kernels of {len(variants)} kinds of pushes"
            f"{'' if args.scenes else ', and those of branches,'} are in {folder}: "
            f"{compiling.kernels()} compiled by this process, {time.monotonic() - began:.0f} s"
        )
    return exits.DONE


def asked_for(scenes: Iterable[str]) -> list[Variant]:
    """The variants of scene files; all where none is given."""
    from derod.scene import load_scene

    loaded = [load_scene(path) for path in scenes]
    from derod.pushing.exercise import VARIANTS, variant_of

    return list(dict.fromkeys(map(variant_of, loaded))) or list(VARIANTS)


def kernels_of(variants: Iterable[Variant]) -> list[Wanted]:
    """All kernels that pushes of the variants call, each once."""
    from derod.algebra.survey import survey
    from derod.cli.helper import MORE_PATIENCE
    from derod.pushing.exercise import first_increments, instabilities

    found: dict[Any, Wanted] = {}
    for variant in variants:
        for one in [
            *survey(partial(first_increments, variant)),
            *survey(partial(instabilities, variant), MORE_PATIENCE),
        ]:
            found.setdefault((id(one.kernel), one.types), one)
    return list(found.values())


def compile_missing(wanted: Iterable[Wanted], *, branches: bool, quiet: bool) -> None:
    """Compile what is in no cache, in two processes where there are two cores."""
    from derod.algebra import compiling
    from derod.cli.compiling import Words, compile_all, start_helper

    missing = [one for one in wanted if not one.is_kept()]
    words = Words(0 if branches else len(missing))
    tell = (lambda name, begins: None) if quiet else words
    compiling.listen(tell)
    helper = start_helper(missing, [], tell)
    try:
        if branches:
            from derod.branches.exercise import trace_a_path

            trace_a_path()
        compile_all(missing)
    finally:
        compiling.forget(tell)
        words.clear()
        if helper is not None:
            helper.end()


def note_all_ready(variants: Iterable[Variant]) -> None:
    """Note that the variants' kernels are there, so that pushes need not look."""
    from derod.cli.compiling import note_ready

    for variant in variants:
        note_ready(variant)


def cache_folder() -> str | None:
    """Where kernels are kept, or None where that ends with this process."""
    from derod.algebra.cache import VARIABLE, is_temporary

    folder = os.environ.get(VARIABLE)
    return None if not folder or is_temporary(folder) else folder
