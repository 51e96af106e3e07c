"""A cache of compiled kernels that never goes stale.

numba notices a change in a cached function's own file only: a kernel whose callee changed in
another module keeps running the old code. So every state of the sources gets a cache folder of its
own, named by their hash. Packages with kernels call ``point_numba_at_own_cache`` before they import
numba.

BLAS threads are not set here: the small systems of a push are solved in our own kernels, and a
process that wants OpenBLAS with one thread has to say so before numpy is imported.
"""

from __future__ import annotations

import getpass
import hashlib
import os
import platform
import shutil
import sys
import tempfile
from importlib import metadata
from pathlib import Path

KEEP = 6
VARIABLE = "NUMBA_CACHE_DIR"
OURS = "DEROD_NUMBA_CACHE_DIR"  # tells a folder that we chose, inherited, from one the user chose
PACKAGE = Path(__file__).parent


def point_numba_at_own_cache() -> None:
    """Set numba's cache folder for this state of the sources, unless the user has set one."""
    chosen = os.environ.get(VARIABLE)
    if chosen is not None and chosen != os.environ.get(OURS):
        return
    folder = _made_folder(f"numba-{source_hash(PACKAGE)}")
    if str(folder) != chosen:
        os.environ[VARIABLE] = os.environ[OURS] = str(folder)
    if "numba" in sys.modules:
        sys.modules["numba"].config.CACHE_DIR = str(folder)


def source_hash(package: Path) -> str:
    """Hash of all sources in folders that hold kernels, and of the versions that compile them.

    Whole folders, because constants that kernels use may lie in a module without any.
    """
    contents = {path: path.read_bytes() for path in sorted(package.rglob("*.py"))}
    kernels = {path.parent for path, text in contents.items() if b"jit" in text}
    digest = hashlib.sha256(f"{metadata.version('numba')} {platform.python_version()}".encode())
    for path, text in contents.items():
        if path.parent in kernels and path != Path(__file__):
            digest.update(f"\0{path.relative_to(package)}\0{len(text)}\0".encode())
            digest.update(text)
    return digest.hexdigest()[:16]


def _made_folder(name: str) -> Path:
    """The cache folder ``name``, made where we may write; those long unused are removed."""
    home = user_cache_folder()
    folder = home / "derod" / name
    try:
        folder.mkdir(parents=True, exist_ok=True)
        os.utime(folder)
    except OSError:  # a read-only home
        folder = Path(tempfile.gettempdir()) / f"derod-{getpass.getuser()}" / name
        folder.mkdir(parents=True, exist_ok=True)
        os.utime(folder)
    prune(folder.parent)
    return folder


def prune(parent: Path) -> None:
    """Keep the ``KEEP`` cache folders used last."""
    folders = sorted(parent.glob("numba-*"), key=_last_used, reverse=True)
    for folder in folders[KEEP:]:
        shutil.rmtree(folder, ignore_errors=True)  # another process may be at it too


def _last_used(folder: Path) -> float:
    try:
        return folder.stat().st_mtime
    except OSError:  # removed meanwhile
        return 0.0


def user_cache_folder() -> Path:
    """Where this system keeps caches of the user."""
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA", Path.home() / "AppData" / "Local"))
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches"
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
