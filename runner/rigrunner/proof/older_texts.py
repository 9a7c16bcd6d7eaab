"""Rewrites texts of older programs as they are written today, for comparisons.

Meaning and numbers stay, except the value itself, which is beside the reason in each document and
compared there.
"""

from __future__ import annotations

import re

_REASON = re.compile(
    r"(?P<of>.*: )?[^:]+? is (?P<away>[^:]+?) (?P<side>within|outside) the limit (?P<limit>[^:]+?)"
    r"(?:, (?P<how>by at least|but by less than|but by no more than|by more than"
    r"|but no value is within both limits by) (?P<width>[^:]+?))?"
    r"(?P<why>: conformity is not demonstrated|: so uncertain a result cannot pass)?\."
)
_WIDTHS = {
    None: "",
    "by at least": " ({width})",
    "but by less than": ", less than {width}",
    "but by no more than": ", no more than {width}",
    "by more than": ", more than {width}",
    "but no value is within both limits by": (
        "; the limits are too close for {width}, so no result can pass"
    ),
}
_UNPROVEN = ": conformity is not demonstrated"


def today(text: str) -> str:
    """Return the reason of a verdict as written since version 0.2; other texts unchanged."""
    old = _REASON.fullmatch(text)
    if old is None:
        return text
    of, limit, away = old["of"] or "", old["limit"], old["away"]
    inside, outside = f"Margin to the limit {limit}: {away}", f"Outside the limit {limit} by {away}"
    place = inside if old["side"] == "within" else outside
    if of.startswith(("At ", "The mean: ")):
        place = f"{place[:1].lower()}{place[1:]}"
    why = "; conformity is not demonstrated" if old["why"] == _UNPROVEN else ""
    return f"{of}{place}{_WIDTHS[old['how']].format(width=old['width'])}{why}."
