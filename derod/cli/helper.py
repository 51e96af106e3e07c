"""The process that compiles kernels beside another one (``derod.cli.compiling``).

It reads its orders from standard input, says on standard output what it does, and ends when standard input is
closed: with the process that started it, however that ends.
"""

from __future__ import annotations

import os
import pickle
import sys
import threading
from collections.abc import Iterable, Sequence
from functools import partial
from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from derod.algebra.survey import Wanted
    from derod.pushing.exercise import Variant

MORE_PATIENCE = 300_000  # calls without news in a survey of descents: modes are found by iteration


def orders(first: Sequence[Wanted], later: Iterable[Variant]) -> bytes:
    """What the process is to compile: kernels, then those of the folds and unstable states of variants."""
    from derod.algebra.cache import VARIABLE

    named = [(w.kernel.py_func.__module__, w.kernel.py_func.__qualname__, w.types) for w in first]
    return pickle.dumps((os.environ.get(VARIABLE), named, [tuple(one) for one in later]))


def main() -> None:
    """Compile what is ordered."""
    folder, named, later = pickle.load(sys.stdin.buffer)
    threading.Thread(target=_end_with_input, daemon=True).start()
    import derod.algebra  # chooses the cache folder
    from derod.algebra import compiling
    from derod.algebra.cache import VARIABLE
    from derod.algebra.survey import Wanted, survey
    from derod.cli.compiling import compile_all

    assert derod.algebra
    if os.environ.get(VARIABLE) != folder:
        raise SystemExit(f"its cache would be {os.environ.get(VARIABLE)}, not {folder}")
    compiling.listen(_say)
    compile_all(Wanted(_kernel(module, name), types) for module, name, types in named)
    print("first", flush=True)
    from derod.pushing.exercise import Variant, instabilities

    for fields in later:
        variant = Variant(*fields)
        compile_all(survey(partial(instabilities, variant), MORE_PATIENCE))


def _kernel(module: str, name: str) -> Any:
    return getattr(import_module(module), name)


def _say(name: str, begins: bool) -> None:
    print("begin" if begins else "done", name, flush=True)


def _end_with_input() -> None:
    while os.read(0, 1024):  # not sys.stdin: its lock would be held when the interpreter ends
        pass
    os._exit(0)  # also while a kernel is compiled: it is of no use to anybody then
