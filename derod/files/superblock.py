"""The first 48 bytes of an HDF5 file of ours, read and written by ourselves.

HDF5 trusts them before anything else: where the file ends, and whether somebody writes it. The layout
is that of version 3, which every file written with ``libver=v110`` has::

    0   signature (8)        12  base address (8)       28  end of file (8)
    8   version, 3           20  extension's address    36  root group's address (8)
    9   size of offsets, 8       (8)                    44  checksum of bytes 0..43 (4)
    10  size of lengths, 8
    11  flags: 1 open for writing, 4 open for SWMR writing
"""

from __future__ import annotations

import struct
from typing import NamedTuple

SIZE = 48
SIGNATURE = b"\x89HDF\r\n\x1a\n"
VERSION = 3
_LAYOUT = struct.Struct("<8sBBBBQQQQ")
_WORD = 0xFFFFFFFF
_START = 0xDEADBEEF


class NotOursError(ValueError):
    """Bytes that begin no HDF5 file that derod writes."""


class OtherKindError(NotOursError):
    """Bytes that begin an HDF5 file of another kind."""


class Superblock(NamedTuple):
    """What the first bytes say."""

    flags: int
    base: int
    extension: int
    end: int
    root: int

    @property
    def live(self) -> bool:
        """Whether a writer has opened the file and has not closed it: it writes, or was killed."""
        return bool(self.flags)

    def pack(self) -> bytes:
        """The 48 bytes that say this."""
        head = _LAYOUT.pack(SIGNATURE, VERSION, 8, 8, *self)
        return head + struct.pack("<I", lookup3(head))


def unpack(head: bytes) -> Superblock:
    """Read the first bytes of a file; raises NotOursError with the reason."""
    if len(head) < len(SIGNATURE) or not head.startswith(SIGNATURE):
        raise NotOursError("it is no HDF5 file")
    if len(head) < SIZE:
        raise NotOursError("its end is missing")
    _, version, offsets, lengths, *fields = _LAYOUT.unpack_from(head)
    if version != VERSION or (offsets, lengths) != (8, 8):
        raise OtherKindError("it is an HDF5 file of another kind")
    if struct.unpack_from("<I", head, SIZE - 4)[0] != lookup3(head[: SIZE - 4]):
        raise NotOursError("its first bytes are damaged")
    block = Superblock(*fields)
    if block.base != 0:
        raise OtherKindError("it is an HDF5 file of another kind")
    return block


def lookup3(data: bytes) -> int:
    """Bob Jenkins' hash of ``data`` (not empty), the checksum of all of HDF5's metadata."""
    a = b = c = (_START + len(data)) & _WORD
    whole = (len(data) - 1) // 12
    for i in range(whole):
        x, y, z = struct.unpack_from("<III", data, 12 * i)
        a, b, c = _mixed((a + x) & _WORD, (b + y) & _WORD, (c + z) & _WORD)
    x, y, z = struct.unpack("<III", data[12 * whole :].ljust(12, b"\0"))
    return _finished((a + x) & _WORD, (b + y) & _WORD, (c + z) & _WORD)


def _turned(x: int, bits: int) -> int:
    return ((x << bits) | (x >> (32 - bits))) & _WORD


def _mixed(a: int, b: int, c: int) -> tuple[int, int, int]:
    for bits in ((4, 6, 8), (16, 19, 4)):
        a = ((a - c) & _WORD) ^ _turned(c, bits[0])
        c = (c + b) & _WORD
        b = ((b - a) & _WORD) ^ _turned(a, bits[1])
        a = (a + c) & _WORD
        c = ((c - b) & _WORD) ^ _turned(b, bits[2])
        b = (b + a) & _WORD
    return a, b, c


def _finished(a: int, b: int, c: int) -> int:
    for bits in (14, 11, 25, 16, 4, 14, 24):
        c = ((c ^ b) - _turned(b, bits)) & _WORD
        a, b, c = b, c, a  # the next one is a, then b, then c again
    return b
