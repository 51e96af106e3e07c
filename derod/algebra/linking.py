"""Callees that are long are linked in when their caller has been optimised, not before.

numba links what a kernel calls into the kernel's module and optimises all of it again: the gradient and the
Hessian, which are too long to be inlined, in each of six callers. Linked in afterwards they are as they
were optimised for themselves. That is a quarter of all compilation; rows are the same bit by bit, and a
push takes as long as before (docs/cold-start.md). Only our own kernels are compiled so.
"""

from __future__ import annotations

from typing import Any

from derod.algebra import compiling

LONG = 50_000  # bytes of bitcode; LLVM inlines nothing of a tenth of that


def link_long_callees_last() -> None:
    """Change numba's order, where it is as we know it; imports numba."""
    from numba.core.codegen import CPUCodeLibrary

    known = ("finalize", "_optimize_final_module", "_get_module_for_linking")
    if hasattr(CPUCodeLibrary, "derod_late") or not all(hasattr(CPUCodeLibrary, n) for n in known):
        return
    finalize_all, optimise = CPUCodeLibrary.finalize, CPUCodeLibrary._optimize_final_module

    def finalize(self: Any) -> None:
        libraries = self._linking_libraries
        late = [one for one in libraries if is_long(one)] if compiling.is_at_ours() else []
        if late:
            self._linking_libraries = [one for one in libraries if one not in late]
            self.derod_late = late
        try:
            finalize_all(self)
        finally:
            self._linking_libraries = libraries
            self.derod_late = ()

    def optimise_then_link(self: Any) -> None:
        optimise(self)
        for library in dict.fromkeys(self.derod_late):
            self._reload_init.update(library._reload_init)
            self._final_module.link_in(library._get_module_for_linking(), preserve=True)

    for name, value in {
        "derod_late": (),
        "finalize": finalize,
        "_optimize_final_module": optimise_then_link,
    }.items():
        setattr(CPUCodeLibrary, name, value)


def is_long(library: Any) -> bool:
    """Whether what is linked in is too long to be inlined."""
    return len(library._get_module_for_linking().as_bitcode()) > LONG
