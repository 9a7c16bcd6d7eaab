"""Compare the results derived from a stored run now with those derived when it was sealed."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rigrunner.analysis.document import document
from rigrunner.analysis.revisions import FIRST
from rigrunner.api.errors import DataError
from rigrunner.run.set_points import estimates_of_packages, named_place, other_results, unread

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from rigrunner.api.results import Result
    from rigrunner.runfile import StoredRun

TOLERANCE = 1e-3
"""Tolerance as a fraction of the standard uncertainty: sums of different machines differ by less,
and no printed digit shows it."""

_NUMBERS = ("value", "standard_uncertainty", "expanded_uncertainty_95")


def refuse_other_numbers(stored: StoredRun, result: Result) -> None:
    """Raise DataError if the primary method's numbers are not those of the first analysis.

    They differ if the program or a plugin changed since the run, even within one version. For a run
    that was sealed without a result there is nothing to compare.
    """
    if stored.result_document is None:
        return
    if keys := unread(stored.result_document):
        raise DataError(
            f"{stored.header.run_id}: no installed package reads {', '.join(keys)} of its result",
            hint="certify where the package is installed with which the run was made",
        )
    before = dict(_estimates(stored.result_document))
    after = dict(_estimates(document(result)))
    for name in before | after:
        was, now = before.get(name), after.get(name)
        if was is not None and now is not None and _same(was, now):
            continue
        revisions = stored.result_document.get("revisions", {})
        changed = (
            f"{method} has revision {revision}, the run was computed by revision {then}"
            for method, revision in result.revisions.items()
            if revision != (then := revisions.get(method, FIRST))
        )
        raise DataError(
            f"{stored.header.run_id} gives different numbers than when it was sealed:"
            f" {name} was {_text(was)}, is {_text(now)}",
            hint=f"{'; '.join(changed) or 'the program or a plugin changed'}; certify with the"
            " versions of the run, or repeat it",
        )


def _estimates(content: Mapping[str, Any]) -> Iterator[tuple[str, Mapping[str, Any]]]:
    headline = content.get("headline") or {}
    yield "the mean", headline.get("compensated") or {}
    for place, estimate in estimates_of_packages(content):
        if "note" not in estimate:
            yield place, estimate
    yield from ((named_place(result), result["estimate"]) for result in other_results(content))


def _same(then: Mapping[str, Any], now: Mapping[str, Any]) -> bool:
    old: list[Any] = [then.get(name) for name in _NUMBERS]
    new: list[Any] = [now.get(name) for name in _NUMBERS]
    if None in old or None in new:
        return old == new
    allowed = TOLERANCE * then["standard_uncertainty"]
    return all(abs(one - other) <= allowed for one, other in zip(old, new, strict=True))


def _text(estimate: Mapping[str, Any] | None) -> str:
    if not estimate:
        return "not there"
    value, width = estimate.get("value"), estimate.get("expanded_uncertainty_95")
    shown_value = "unknown" if value is None else f"{value:.6g}"
    shown_width = "unknown" if width is None else f"{width:.4g}"
    return f"{shown_value} ± {shown_width} {estimate.get('unit', '')}"
