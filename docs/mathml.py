"""mkdocs' hook that turns formulas into MathML, which browsers draw without a script, and more."""

from __future__ import annotations

import re
from html import unescape
from typing import Any

from latex2mathml.converter import convert

FORMULA = re.compile(
    r'<(span|div) class="arithmatex">(?:\\\(|\\\[)(.*?)(?:\\\)|\\\])</\1>', re.DOTALL
)


def on_page_content(html: str, **_: Any) -> str:
    """The page with its formulas as MathML."""
    html = html.replace("<p>::</p>", "")  # reST's mark of a block, in docstrings
    return FORMULA.sub(
        lambda found: convert(
            unescape(found[2]), display="block" if found[1] == "div" else "inline"
        ),
        html,
    )
