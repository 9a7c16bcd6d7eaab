"""Render a page as one self-contained HTML file."""

from __future__ import annotations

import re
from functools import cache
from importlib.resources import files
from typing import TYPE_CHECKING

from jinja2 import ChoiceLoader, Environment, PackageLoader, PrefixLoader, StrictUndefined
from markupsafe import Markup

from rigrunner.api.texts import visible
from rigrunner.plots import draw
from rigrunner_reports.contents import contents
from rigrunner_reports.page import make_page
from rigrunner_reports.section import installed_sections

if TYPE_CHECKING:
    from rigrunner.api import ReportInput

PACKAGE = "rigrunner_reports"
_BESIDE_A_NUMBER = re.compile(
    r"(?<=\d) (?=m?N·m|Hz|%|k?N\b)"  # 0.7 N·m
    r"|(?<=[=≤≥±]) (?=[\d+\N{MINUS SIGN}])|(?<=&[gl]t;) (?=\d)"  # ≤ 0.95, and < 0.01 in HTML
    r"|(?<=\b[A-Za-z]) (?==)"  # k = 2
)


def html(report: ReportInput) -> bytes:
    """Return the report as UTF-8; the same input gives the same bytes."""
    page = make_page(report)
    return fill("report.html.j2", page=page, contents=list(contents(report, page)))


def fill(template: str, **values: object) -> bytes:
    """Return one of our templates, filled in, with the shared style, as UTF-8."""
    style = files(PACKAGE).joinpath("templates", "style.css").read_text(encoding="utf-8")
    # the style sheet is ours; what a lab wrote enters it by css_string alone
    common = {"style": Markup(style), "css_string": css_string}  # noqa: S704  (see above)
    return _environment().get_template(template).render(**common, **values).encode("utf-8")


def css_string(text: str) -> Markup:
    """Return a CSS string that cannot end itself, nor its <style> element.

    A blank ends each escape: otherwise the next letter could become part of it.
    """
    safe = "".join(
        char if char.isascii() and (char.isalnum() or char in " .-_") else f"\\{ord(char):06x} "
        for char in text
    )
    return Markup(f'"{safe}"')  # noqa: S704  (everything but letters and digits is escaped)


def unbroken(markup: str) -> Markup:
    """Return a part of a page whose numbers keep unit and sign on the line (SI Brochure, 5.4.3)."""
    return Markup(_BESIDE_A_NUMBER.sub("\N{NO-BREAK SPACE}", markup))  # noqa: S704  (it was escaped)


def _seen(value: object) -> object:
    """Return what a template prints; hidden characters of a text that a device gave are visible."""
    if not isinstance(value, str) or (shown := visible(value)) == value:
        return value
    return Markup(shown) if isinstance(value, Markup) else shown  # noqa: S704  (escapes add no markup)


@cache  # the templates are compiled once: that takes longer than filling them
def _environment() -> Environment:
    names = {section.package for sections in installed_sections() for section in sections.sections}
    others = {name: PackageLoader(name) for name in names if name}
    environment = Environment(
        loader=ChoiceLoader((PackageLoader(PACKAGE), PrefixLoader(others))),
        autoescape=True,
        finalize=_seen,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        optimized=False,  # it folds constants, of which there are next to none
    )
    environment.filters["unbroken"] = unbroken
    environment.filters["drawn"] = draw
    return environment
