"""Kernels that came with the package, compiled: a wheel may carry them in ``derod/compiled``.

numba looks a kernel up by its argument types, the hash of its bytecode, and the "magic tuple" of the
machine: triple, name and features of the CPU. Only the last belongs to the host. Where a kernel is not in
the user's cache it is looked up here, for the tuple that the wheel was built for, if

- the sources of all kernels, numba's version and Python's minor version are those of the wheel,
- the CPU has every feature that the kernels were compiled for, and the triple is the same,
- nobody but us or root can have written what is here, as for the package's own sources,
- the file has the checksum that the manifest says.

Anything else counts as not there, and the kernel is compiled. Nothing is copied and nothing written: the
user's cache always comes first, and holds only what was compiled on this machine.
"""

from __future__ import annotations

import hashlib
import json
import os
import pickle
import stat
import sys
from functools import cache, lru_cache
from importlib import metadata
from pathlib import Path
from typing import Any

FOLDER = "compiled"
MANIFEST = "manifest.json"
FORMAT = 1
OFF = "DEROD_COMPILED"  # set to "no", a package's compiled kernels are not used
PACKAGE = Path(__file__).parents[1]


def load(cache_path: str, index_name: str, stamp: Any, key: Any) -> Any:
    """What the package has under numba's ``key`` for the index of that name, or None."""
    if not _wanted():
        return None
    folder = _folders().get(Path(cache_path).name)
    if folder is None:
        return None
    entries = _entries(f"{folder}/{index_name}", _hashable(stamp))
    types, magic, hashes = key
    if not entries or not _fits(*magic):
        return None
    name = entries.get((types, hashes))
    data = None if name is None else _checked(f"{folder}/{name}")
    return None if data is None else pickle.loads(data)


@cache
def variants() -> frozenset[str]:
    """Names of the scenes' variants whose kernels are all here and may be used on this machine."""
    if not _wanted():
        return frozenset()
    from numba.core.registry import cpu_target

    manifest = _manifest()
    fits = bool(manifest) and _fits(*cpu_target.target_context.codegen().magic_tuple())
    return frozenset(manifest["variants"] if fits else ())


def _wanted() -> bool:
    return os.environ.get(OFF) != "no"


@cache
def _manifest() -> dict[str, Any]:
    """What the kernels were built from and for; empty where they are of no use here, or not there."""
    from derod.algebra.cache import sources_digest

    folder = PACKAGE / FOLDER
    try:
        if not is_trusted(folder):
            return {}
        manifest = json.loads((folder / MANIFEST).read_bytes())
        known = (
            manifest["format"] == FORMAT
            and manifest["numba"] == metadata.version("numba")
            and manifest["python"] == python_minor()
            and manifest["sources"] == sources_digest(PACKAGE)
            and isinstance(manifest["files"], dict)
            and isinstance(manifest["variants"], list)
            and isinstance(manifest["magic"], list)
        )
    except (OSError, ValueError, KeyError, TypeError):  # none, or damaged: kernels are compiled
        return {}
    return manifest if known else {}


def python_minor() -> str:
    """The version of Python that bytecode and objects depend on, with its ABI flags."""
    return f"{sys.version_info[0]}.{sys.version_info[1]}{getattr(sys, 'abiflags', '')}"


@lru_cache(maxsize=4)
def _fits(triple: str, cpu: str, features: str) -> bool:
    """Whether code for the manifest's machine runs on this one, as numba sees it."""
    built_triple, _, built_features = _manifest().get("magic", ("", "", ""))
    missing = needed(built_features) - needed(features)
    return bool(built_triple == triple and not missing)


def needed(features: str) -> set[str]:
    """The features that are switched on in LLVM's list of them."""
    return {part[1:] for part in features.split(",") if part.startswith("+")}


@cache
def _folders() -> dict[str, str]:
    """The package's folders with kernels, by the name that numba gives to a folder's part of the cache."""
    folders = {name.rpartition("/")[0] for name in _manifest().get("files", ())}
    named = {}
    for folder in folders:
        inside = os.path.abspath(PACKAGE.joinpath(*folder.split("/")))  # noqa: PTH100  as numba does
        digest = hashlib.sha1(inside.encode(), usedforsecurity=False).hexdigest()
        named[f"{os.path.basename(inside)}_{digest}"] = folder  # noqa: PTH119
    return named


@cache
def _entries(name: str, stamp: Any) -> dict[Any, str]:
    """Data files of an index by types and hashes of the function, if it is of the source as it is."""
    data = _checked(name)
    if data is None:
        return {}
    import numba

    head = pickle.dumps(numba.__version__, protocol=-1)
    if not data.startswith(head):
        return {}
    stored, overloads = pickle.loads(data[len(head) :])
    if stored != stamp:
        return {}
    magic = tuple(_manifest()["magic"])
    return {
        (types, hashes): file for (types, made, hashes), file in overloads.items() if made == magic
    }


def _hashable(stamp: Any) -> Any:
    return tuple(stamp) if isinstance(stamp, list) else stamp


def _checked(name: str) -> bytes | None:
    """The content of a file that is as the manifest says; None for any other."""
    digest = _manifest().get("files", {}).get(name)
    if digest is None or ".." in name.split("/"):
        return None
    try:
        data = PACKAGE.joinpath(FOLDER, *name.split("/")).read_bytes()
    except OSError:
        return None
    return data if digest == file_digest(data) else None


def file_digest(data: bytes) -> str:
    """The checksum of a file in the manifest."""
    return hashlib.blake2b(data, digest_size=16).hexdigest()


def is_trusted(folder: Path) -> bool:
    """Whether only we or root can have put something into ``folder``.

    A group may write if it is the user's own: of the same name and number, as systems with an umask of
    002 have it.
    """
    if not hasattr(os, "geteuid"):
        return True  # Windows: as far as the package's sources are to be trusted
    import grp
    import pwd

    real = Path(os.path.realpath(folder))
    for place in (real, real / MANIFEST, *real.parents):
        here = place.lstat()
        if here.st_uid not in (0, os.geteuid()):
            return False
        writers = here.st_mode & 0o022
        if writers & 0o002 and not here.st_mode & stat.S_ISVTX:
            return False
        if writers & 0o020 and here.st_gid not in (0, _own_group(grp, pwd)):
            return False
    return True


def _own_group(grp: Any, pwd: Any) -> int:
    """The number of the user's private group, -1 if there is none."""
    try:
        user = pwd.getpwuid(os.geteuid())
        group = grp.getgrgid(user.pw_gid)
    except KeyError:
        return -1
    alone = group.gr_name == user.pw_name and set(group.gr_mem) <= {user.pw_name}
    return int(user.pw_gid) if alone else -1
