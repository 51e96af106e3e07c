"""Pages of the documentation that are written from the code: written anew, or checked."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path


def write_or_check(path: Path, page: Callable[[], str], description: str) -> int:
    """Write the page; with ``--check`` return 1 where the file is not what the code says."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--check", action="store_true")
    if parser.parse_args().check:
        return int(path.read_text() != page())
    path.write_text(page())
    return 0
