"""A cache of compiled kernels that never goes stale.

numba notices a change in a cached function's own file only: a kernel whose callee changed in
another module keeps running the old code. So every state of the sources gets a cache folder of its
own, named by their hash. Packages with kernels call ``point_numba_at_own_cache`` before they import
numba.

BLAS threads are not set here: the small systems of a push are solved in our own kernels, and a
process that wants OpenBLAS with one thread has to say so before numpy is imported.
"""

from __future__ import annotations

import atexit
import contextlib
import hashlib
import os
import platform
import re
import shutil
import stat
import sys
import tempfile
from collections.abc import Iterator
from functools import cache
from importlib import metadata
from pathlib import Path

KEEP = 6
VARIABLE = "NUMBA_CACHE_DIR"
OURS = "DEROD_NUMBA_CACHE_DIR"  # tells a folder that we chose, inherited, from one the user chose
PACKAGE = Path(__file__).parents[1]
USES_JIT = re.compile(rb"^from (?:numba|derod\.algebra\.jit) import|^import numba", re.MULTILINE)
NO_KERNELS = ("scene",)
IMPORTS = re.compile(rb"^from (derod[\w.]*) import (\([^)]*\)|.*)", re.MULTILINE)
_temporary: set[str] = set()


def point_numba_at_own_cache() -> None:
    """Set numba's cache folder for this state of the sources, unless the user has set one."""
    chosen = os.environ.get(VARIABLE)
    if chosen is not None and chosen != os.environ.get(OURS):
        _prepare_numba(None)
        return
    folder = _made_folder(f"numba-{source_hash(PACKAGE)}")
    if str(folder) != chosen:
        os.environ[VARIABLE] = os.environ[OURS] = str(folder)
    if "numba" in sys.modules:
        sys.modules["numba"].config.CACHE_DIR = str(folder)
    _prepare_numba(folder)


def _prepare_numba(folder: Path | None) -> None:
    """Import numba, and have it work as we need it; ``folder`` is the cache if we chose it."""
    from derod.algebra.claims import claim_kernels
    from derod.algebra.compiling import watch_numba
    from derod.algebra.inlining import copy_names_once
    from derod.algebra.linking import link_long_callees_last
    from derod.algebra.mending import mend_caches

    mend_caches(folder)
    claim_kernels()
    watch_numba()
    copy_names_once()
    link_long_callees_last()


def source_hash(package: Path) -> str:
    """Hash of all sources that kernels are made of, and of the versions that compile them."""
    made_of = f"{metadata.version('numba')} {platform.python_version()} {sources_digest(package)}"
    return hashlib.sha256(made_of.encode()).hexdigest()[:16]


@cache
def sources_digest(package: Path) -> str:
    """Hash of all sources that kernels are made of."""
    digest = hashlib.sha256()
    for path, text in sorted(kernel_sources(package).items()):
        digest.update(f"\0{path.relative_to(package).as_posix()}\0{len(text)}\0".encode())
        digest.update(text)
    return digest.hexdigest()


def kernel_sources(package: Path) -> dict[Path, bytes]:
    """The modules that hold kernels, and those that they import: constants may lie there."""
    contents = {path: path.read_bytes() for path in package.rglob("*.py")}
    left = [path for path, text in contents.items() if USES_JIT.search(text)]
    found: dict[Path, bytes] = {}
    while left:
        path = left.pop()
        if path in found or path not in contents or path.parent.name in NO_KERNELS:
            continue
        found[path] = contents[path]
        for home, names in IMPORTS.findall(contents[path]):
            folder = package.joinpath(*home.decode().split(".")[1:])
            left.append(folder.with_suffix(".py"))
            left += [folder / f"{name.decode()}.py" for name in re.findall(rb"\w+", names)]
    found.pop(Path(__file__), None)
    return found


def _made_folder(name: str) -> Path:
    """The cache folder ``name``, made where only we may write; those long unused are removed.

    What lies in it is executed, so it must be nobody else's: see ``is_private``. The first of the user's
    cache folder, a folder of the user's in the temporary folder, and a fresh one that will do.
    """
    for home in _homes():
        try:
            parent = home / "derod"
            home.mkdir(parents=True, exist_ok=True)
            if _made_private(parent) and _made_private(parent / name):
                os.utime(parent / name)
                prune(parent)
                return parent / name
        except OSError:  # read-only, or no folder: the next one
            continue
    fresh = Path(tempfile.mkdtemp(prefix="derod-"))  # mode 0700, a name nobody could know
    _temporary.add(str(fresh))
    atexit.register(shutil.rmtree, fresh, ignore_errors=True)
    return fresh


def is_temporary(folder: str) -> bool:
    """Whether a cache folder is removed at the end of this process."""
    return folder in _temporary


def _homes() -> Iterator[Path]:
    """Where the folder may lie, the best place first."""
    with contextlib.suppress(RuntimeError, KeyError):  # neither HOME nor an entry in passwd
        yield user_cache_folder()
    user = os.getuid() if hasattr(os, "getuid") else "user"
    yield Path(tempfile.gettempdir()) / f"derod-{user}"


def _made_private(folder: Path) -> bool:
    """Make ``folder``, or find it, as one that only we may write into."""
    with contextlib.suppress(FileExistsError):
        folder.mkdir(mode=0o700)
    return is_private(folder)


def is_private(folder: Path) -> bool:
    """Whether only we can have put something into ``folder``.

    It must be a real folder, no link, owned by us, written by nobody else; one that others may only
    read is closed to them. So must those above it be, or belong to root, or be like /tmp, where nobody
    may rename what is another's.
    """
    if not hasattr(os, "getuid"):
        return True  # Windows: the user's profile is the user's
    here = folder.lstat()
    if not stat.S_ISDIR(here.st_mode) or here.st_uid != os.geteuid() or here.st_mode & 0o022:
        return False
    if here.st_mode & 0o077:
        folder.chmod(0o700)
    for parent in Path(os.path.realpath(folder)).parents:
        above = parent.lstat()
        shared = above.st_mode & 0o022 and not above.st_mode & stat.S_ISVTX
        if above.st_uid not in (0, os.geteuid()) or shared:
            return False
    return True


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
        return Path(os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local")
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches"
    chosen = os.environ.get("XDG_CACHE_HOME", "")
    return Path(chosen) if os.path.isabs(chosen) else Path.home() / ".cache"  # noqa: PTH117
