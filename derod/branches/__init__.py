"""The paper's boundary-value problem and its solution branches; shares no code with the discrete
rod."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from derod.branches.heavy import HeavyState as HeavyState
    from derod.branches.heavy import heavy_states as heavy_states
    from derod.branches.parameters import Parameters as Parameters

_PUBLIC = {
    "HeavyState": "derod.branches.heavy",
    "heavy_states": "derod.branches.heavy",
    "Parameters": "derod.branches.parameters",
}


def __getattr__(name: str) -> Any:
    """Public names, imported when they are asked for: kernels take a second to load."""
    if name in _PUBLIC:
        from importlib import import_module

        return getattr(import_module(_PUBLIC[name]), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
