"""Cached kernels that were damaged are compiled again.

numba takes what its cache holds for what it wrote: a damaged index is a traceback at every start, for
ever, and a damaged kernel is run. Our files end with a checksum, which numba itself does not read; what does
not fit, or cannot be read, counts as not there.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
from pathlib import Path
from typing import Any

from derod.algebra import shipped

MARK = b"derod-check:"
SIZE = 16
_folders: set[str] = set()


def mend_caches(folder: Path | None) -> None:
    """Mend the caches in ``folder`` from now on, and look for kernels in the package; imports numba."""
    from numba.core import caching

    if folder is not None:
        _folders.add(str(folder))
    if not issubclass(caching.IndexDataCacheFile, _Mending):
        mending = type("MendingCacheFile", (_Mending, caching.IndexDataCacheFile), {})
        setattr(caching, "IndexDataCacheFile", mending)  # noqa: B010  a type, to mypy


def is_in_our_cache(path: str) -> bool:
    """Whether a folder of numba's lies in a cache folder of ours."""
    return any(path.startswith(folder) for folder in _folders)


def check(data: bytes) -> bytes:
    """What follows ``data`` in a file."""
    return MARK + hashlib.blake2b(data, digest_size=SIZE).digest()


def is_damaged(path: str) -> bool:
    """Whether a file has a checksum that it does not fit.

    One without, from elsewhere or cut short, is left to pickle to judge.
    """
    try:
        whole = Path(path).read_bytes()
    except FileNotFoundError:
        return False
    data, end = whole[: -len(MARK) - SIZE], whole[-len(MARK) - SIZE :]
    return MARK in end and end != check(data)


class _Mending:
    """Put before numba's class of index and data files."""

    _cache_path: str
    _index_path: str

    def _ours(self) -> bool:
        return is_in_our_cache(self._cache_path)

    def load(self, key: Any) -> Any:
        """Load a kernel from the user's cache, or else from the package."""
        data = super().load(key)  # type: ignore[misc]
        if data is None:
            with contextlib.suppress(Exception):  # of pickle, as above; then it is compiled
                name = self._index_name  # type: ignore[attr-defined]
                stamp = self._source_stamp  # type: ignore[attr-defined]
                data = shipped.load(self._cache_path, name, stamp, key)
        return data

    def _load_index(self) -> Any:
        if not self._ours():
            return super()._load_index()  # type: ignore[misc]
        if not is_damaged(self._index_path):
            with contextlib.suppress(Exception):  # pickle raises whatever it likes
                return super()._load_index()  # type: ignore[misc]
        with contextlib.suppress(OSError):
            os.unlink(self._index_path)  # noqa: PTH108
        return {}

    def _load_data(self, name: str) -> Any:
        if not self._ours():
            return super()._load_data(name)  # type: ignore[misc]
        if not is_damaged(self._data_path(name)):  # type: ignore[attr-defined]
            with contextlib.suppress(Exception):
                return super()._load_data(name)  # type: ignore[misc]
        return None  # as if it were not there

    @contextlib.contextmanager
    def _open_for_write(self, filepath: str) -> Any:
        with super()._open_for_write(filepath) as file:  # type: ignore[misc]
            yield file
            if self._ours():
                file.flush()
                file.write(check(Path(file.name).read_bytes()))
