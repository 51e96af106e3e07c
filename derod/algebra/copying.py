"""Copies and scalings that allocate nothing (an array assignment may make a copy of its source)."""

from __future__ import annotations

from derod.algebra.jit import inlined


@inlined
def copy_vector(source, target):
    """Copy the first entries of ``source``, (n,) or longer, into ``target``, (n,)."""
    for i in range(target.size):
        target[i] = source[i]


@inlined
def copy_rows(source, target):
    """Copy ``source`` into ``target``, both (n, m)."""
    for i in range(target.shape[0]):
        for k in range(target.shape[1]):
            target[i, k] = source[i, k]


@inlined
def scale_vector(factor, target):
    """Multiply ``target``, (n,), by a number."""
    for i in range(target.size):
        target[i] *= factor


@inlined
def scale_rows(factor, target):
    """Multiply ``target``, (n, m), by a number."""
    for i in range(target.shape[0]):
        for k in range(target.shape[1]):
            target[i, k] *= factor
