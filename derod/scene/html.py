"""A table as HTML, for notebooks."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape
from typing import Any


def html_table(title: str, head: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    """A table of texts with a title; text is left, numbers are right."""
    cells = "".join(f"<th style='text-align:left'>{escape(str(name))}</th>" for name in head)
    body = "".join(
        "<tr>"
        + "".join(f"<td style='text-align:left'>{escape(str(x))}</td>" for x in row)
        + "</tr>"
        for row in rows
    )
    return (
        f"<div><strong>{escape(title)}</strong><table><thead><tr>{cells}</tr></thead>"
        f"<tbody>{body}</tbody></table></div>"
    )
