"""The house keeps its measure: no circles, small modules, few arguments."""

from __future__ import annotations

import ast
import statistics
from pathlib import Path

PACKAGE = Path(__file__).parents[2] / "derod"
KERNELS = {"kernel", "inlined", "allocating_kernel", "njit"}
MODULES = {
    ".".join(path.relative_to(PACKAGE.parent).with_suffix("").parts).removesuffix(".__init__"): path
    for path in PACKAGE.rglob("*.py")
}


def mark_of(decorator: ast.expr) -> str:
    """The name of a decorator, called or not."""
    return getattr(decorator, "id", getattr(getattr(decorator, "func", None), "id", ""))


def imported(path: Path) -> set[str]:
    """Modules of ours that are imported whenever this one is."""
    found: set[str] = set()

    def look(body: list[ast.stmt]) -> None:
        for node in body:
            if isinstance(node, ast.ImportFrom) and node.module in MODULES:
                for alias in node.names:
                    full = f"{node.module}.{alias.name}"
                    found.add(full if full in MODULES else str(node.module))
            elif isinstance(node, ast.Import):
                found.update(alias.name for alias in node.names if alias.name in MODULES)
            elif (
                isinstance(node, ast.If) and "TYPE_CHECKING" not in ast.unparse(node.test)
            ) or isinstance(node, ast.Try):
                look(node.body)

    look(ast.parse(path.read_text()).body)
    return found


def test_there_are_no_import_circles() -> None:
    graph = {name: imported(path) - {name} for name, path in MODULES.items()}
    while True:
        leaves = {name for name, targets in graph.items() if not targets & graph.keys()}
        if not leaves:
            break
        graph = {name: targets for name, targets in graph.items() if name not in leaves}
    assert not graph, f"circles among {sorted(graph)}"


def test_modules_are_small_and_the_root_is_nearly_empty() -> None:
    sizes = {name: len(path.read_text().splitlines()) for name, path in MODULES.items()}
    assert statistics.median(sizes.values()) <= 150
    assert not [name for name, size in sizes.items() if size > 300]
    assert len(list(PACKAGE.glob("*.py"))) <= 8


def test_functions_take_few_arguments() -> None:
    """At most eight, outside kernels."""
    crowded = []
    for name, path in MODULES.items():
        for node in ast.walk(ast.parse(path.read_text())):
            if not isinstance(node, ast.FunctionDef):
                continue
            marks = {mark_of(decorator) for decorator in node.decorator_list}
            arguments = node.args
            count = len(arguments.posonlyargs) + len(arguments.args) + len(arguments.kwonlyargs)
            if count > 8 and not marks & KERNELS:
                crowded.append(f"{name}.{node.name}: {count}")
    assert not crowded
