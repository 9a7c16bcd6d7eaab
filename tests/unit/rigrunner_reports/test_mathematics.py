"""Equations rendered as MathML."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET

import pytest

from rigrunner.api.findings import Formula
from rigrunner_reports.mathematics import equation

ASCII = {ord("\N{MINUS SIGN}"): "-", ord("\N{DOT OPERATOR}"): "*"}
BETWEEN = {"mfrac": "/", "msup": "^", "msub": "_"}


def read(element):
    """Return MathML as plain text, each group in braces."""
    parts = [read(child) for child in element]
    if element.tag in BETWEEN:
        return f"{{{BETWEEN[element.tag].join(parts)}}}"
    if element.tag == "msqrt":
        return f"root{{{''.join(parts)}}}"
    text = (element.text or "").translate(ASCII)
    return text + "".join(parts)


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("U/I", "{U/I}"),
        ("a - (b - c)", "a-(b-c)"),
        ("a - b - c", "a-b-c"),
        ("a + (b + c)", "a+b+c"),
        ("(a + b)*c", "(a+b)*c"),
        ("a*(b/c)", "a*{b/c}"),
        ("(a/b)**2", "{({a/b})^2}"),
        ("a**b**c", "{a^{b^c}}"),
        ("(a**b)**c", "{({a^b})^c}"),
        ("-(a + b)", "-(a+b)"),
        ("a*-b", "a*(-b)"),
        ("(-a)**2", "{(-a)^2}"),
        ("sqrt(a**2 + b)", "root{{a^2}+b}"),
        ("abs(a) + log(b) + log10(c)", "|a|+ln(b)+lg(c)"),
        ("atan2(a, b)", "atan2(a,b)"),
        ("t_R*R0 - beta_S", "{t_R}*{R_0}-{β_S}"),
        ("2*pi*1.5e-7", "2*π*1.5*{10^-7}"),
        ("number_1 + t", "0 °C+t"),
    ],
)
def test_mathml_shows_the_written_expression(text, shown):
    formula = Formula(of="r", symbol="Y", text=text, quantities={"number_1": "0 °C"})
    root = ET.fromstring(str(equation(formula)))  # noqa: S314  (our own)
    assert read(root) == f"Y={shown}"
    assert root.get("alttext") == f"Y = {text}"


def test_quantities_are_escaped():
    formula = Formula(of="r", symbol="Y", text="q", quantities={"q": "<script>&"})
    shown = str(equation(formula))
    assert "&lt;script&gt;&amp;" in shown
    assert set(re.findall(r"<(\w+)", shown)) == {"math", "mi", "mo", "mtext"}
