"""The check as one self-contained page: what is read before a compensation is approved."""

from __future__ import annotations

from importlib.resources import files
from typing import TYPE_CHECKING

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from rigrunner import __version__
from rigrunner.golden import words
from rigrunner.golden.plots import shifts

if TYPE_CHECKING:
    from rigrunner.golden.overall import Overall

MOST = 300
"""Runs that are listed one by one, the gravest; JSON has all."""
_PACKAGE = "rigrunner.golden"


def page(found: Overall) -> str:
    """Return the check as HTML; the same check gives the same bytes."""
    environment = Environment(
        loader=PackageLoader(_PACKAGE),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    style = files(_PACKAGE).joinpath("templates", "style.css").read_text(encoding="utf-8")
    return environment.get_template(
        "golden.html.j2"
    ).render(
        found=found,
        words=words,
        style=Markup(style),  # noqa: S704  (ours, nothing is put into it)
        plot=shifts(found) if found.shifts_in_u() else "",
        listed=found.runs[:MOST],
        version=__version__,
    )
