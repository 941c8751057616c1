"""HTML pages from Jinja2 templates; whatever a template is given is escaped.

The library is imported when a page is made, so that other commands do not wait for it.
"""

from __future__ import annotations

import re
from functools import cache
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from jinja2 import Environment
    from markupsafe import Markup

__all__ = ["html_page", "trusted"]

_CODE = re.compile("`([^`]+)`")
_POWER = re.compile(r"\^(−?\d+)")


def html_page(template: str, folder: str, **values: Any) -> str:
    """Return the page of a template in `templates` of a folder of meshmark; it may extend those of `report`.

    In templates the filter `prose` keeps a unit beside its number, raises exponents, and sets what stands between
    backticks as code. A value that a template names and does not get is an error.
    """
    return _environment(folder).get_template(template).render(**values)


def trusted(markup: str) -> Markup:
    """Return markup of our own that a template takes as it is."""
    from markupsafe import Markup

    return Markup(markup)


@cache
def _environment(folder: str) -> Environment:
    from jinja2 import ChoiceLoader, Environment, PackageLoader, StrictUndefined

    folders = dict.fromkeys([folder, "report"])
    loader = ChoiceLoader([PackageLoader("meshmark", f"{name}/templates") for name in folders])
    environment = Environment(
        loader=loader, autoescape=True, undefined=StrictUndefined, keep_trailing_newline=True
    )
    environment.filters["prose"] = _prose
    return environment


def _prose(text: str) -> Markup:
    """Return escaped text in which no line begins with a unit, powers are raised, and `commands` are code."""
    from markupsafe import escape

    plain = _CODE.sub(r"<code>\1</code>", str(escape(text)).replace(" %", "&nbsp;%"))
    return trusted(_POWER.sub(r"<sup>\1</sup>", plain))
