"""What `run` and `show` say of torque in a terminal: its keys of a result document."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rigrunner.api.summaries import SummaryParts, table
from rigrunner.signal.rounding import UNKNOWN, estimate_text, with_uncertainty

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    Document = Mapping[str, Any]


def _facts(document: Document) -> Iterator[tuple[str, str]]:
    headline = document["headline"]
    if headline["compensated"]:
        raw, found = headline["raw_peak"], headline["compensated"]
        yield "raw peak", f"{estimate_text(raw)} {raw['unit']}"
        yield (
            document["measurand"]["name"],
            f"{estimate_text(found)} {found['unit']} (95 %, {headline['method']})",
        )


def _blocks(document: Document) -> Iterator[str]:
    yield _points(document)
    yield "\n".join(_fits(document))
    validation = document.get("validation") or {"statements": ()}
    yield "\n".join(f"validation: {each}" for each in validation["statements"])


def _checks(document: Document) -> Iterator[Document]:
    for found in document["compensations"].values():
        yield from found["checks"]


def _points(document: Document) -> str:
    """Return raw peak and every method that could be used, per set-point."""
    if not document["points"]:
        return ""
    methods = {name: found for name, found in document["compensations"].items() if found["points"]}
    header = ["set-point", "raw peak", *methods]
    columns = [
        [estimate_text(point["torque"]) for point in found["points"]] for found in methods.values()
    ]
    rows = []
    for point, *compensated in zip(document["points"], *columns, strict=True):
        frequency, raw = point["set_frequency"], point["raw_peak"]["mean"]["value"]
        rows.append(
            [
                f"{frequency['value']:g} {frequency['unit']}",
                UNKNOWN if raw is None else f"{raw:.3f}",
                *compensated,
            ]
        )
    missing = [
        f"{name}: not applicable: {found['not_applicable']}"
        for name, found in document["compensations"].items()
        if found["not_applicable"]
    ]
    caption = "Torque in N·m, with its expanded uncertainty (95 %)" if methods else "Torque in N·m"
    return "\n".join([caption, table(header, rows, "r" * len(header)), *missing])


def _fits(document: Document) -> Iterator[str]:
    """Say what was fitted to a run that is not compensated: there it is what was found."""
    if document["compensations"] or not document["fits"]:
        return
    yield "Fits of the raw peak over frequency, with standard uncertainties"
    for fit in document["fits"]:
        curve = fit["curve"]
        if curve is None:
            yield f"{fit['name']}: no fit: {fit['problem']}"
            continue
        yield f"{fit['name']}: {curve['formula']}"
        for name, found in curve["coefficients"].items():
            value = with_uncertainty(found["value"], found["standard_uncertainty"])
            yield f"  {name} = {value} {found['unit']}"


SUMMARY = SummaryParts(facts=_facts, blocks=_blocks, checks=_checks)
