"""The survey finds the kernels that numba compiles, for the same types."""

from __future__ import annotations

from typing import Any

import pytest
from numba import njit

from derod.algebra.compiling import is_ours
from derod.algebra.survey import survey
from derod.pushing.exercise import VARIANTS, Variant, first_increments, instabilities

PATIENCE = 300_000


def all_kernels() -> list[Any]:
    """Every kernel that has been compiled or loaded in this process."""
    import sys

    from numba.core.dispatcher import Dispatcher

    modules = [module for name, module in sys.modules.items() if name.startswith("derod.")]
    found = {
        id(v): v for module in modules for v in vars(module).values() if isinstance(v, Dispatcher)
    }
    return [kernel for kernel in found.values() if is_ours(kernel)]


def test_nothing_is_compiled_by_a_survey() -> None:
    before = {id(kernel): len(kernel.overloads) for kernel in all_kernels()}
    wanted = survey(lambda: first_increments(VARIANTS[0]))
    assert len(wanted) > 10 and len({(one.kernel, one.types) for one in wanted}) == len(wanted)
    assert all(len(kernel.overloads) == before.get(id(kernel), 0) for kernel in all_kernels())


def test_a_survey_ends_when_there_is_nothing_new() -> None:
    @njit
    def twice(x: float) -> float:
        return x + x

    calls = []

    def work() -> None:
        while True:
            calls.append(twice(1.0))

    wanted = survey(work, patience=50)
    assert [one.name for one in wanted] == ["twice"] and 50 <= len(calls) < 100
    assert twice(2.0) == 4.0 and len(twice.signatures) == 1, "a kernel again"


def test_an_error_of_python_only_ends_it() -> None:
    assert survey(lambda: 1 / 0) == []
    with pytest.raises(KeyError):
        survey(lambda: {}["of no kernel's"])


@pytest.mark.validation
@pytest.mark.parametrize("variant", VARIANTS, ids=lambda variant: variant.name)
def test_what_is_compiled_is_what_was_found(variant: Variant) -> None:
    """Run for real what was surveyed: nothing else may be compiled or loaded."""
    wanted = {
        (id(one.kernel), one.types)
        for work in (first_increments, instabilities)
        for one in survey(lambda work=work: work(variant), PATIENCE)  # type: ignore[misc]
    }
    before = {(id(k), types) for k in all_kernels() for types in k.overloads}
    first_increments(variant)
    instabilities(variant)
    after = {(id(k), types) for k in all_kernels() for types in k.overloads}
    names = {id(k): k.py_func.__name__ for k in all_kernels()}
    assert not [(names[k], types) for k, types in after - before - wanted]
    assert not [names[k] for k, types in wanted - after], "no more than is needed"
