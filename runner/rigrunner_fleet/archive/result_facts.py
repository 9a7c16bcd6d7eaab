"""What an archive keeps of a result: its set-points, the rig's figures, and the decision."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rigrunner_fleet.archive.documents import (
    at,
    degrees_of_freedom,
    key,
    named,
    number,
    rows,
    text,
    whole,
)

if TYPE_CHECKING:
    from collections.abc import Mapping

Row = dict[str, Any]


def headline(document: object) -> Row:
    """Return the columns of a run that say what it found."""
    found = at(document, "headline", "compensated")
    checks = [*rows(at(document, "checks"))]
    for _, each in named(at(document, "compensations")):
        checks += rows(each.get("checks"))
    failed = sum(each.get("ok") is False for each in checks)
    return {
        "measurand": text(at(document, "measurand", "name")),
        "symbol": text(at(document, "measurand", "symbol")),
        "mandrel": text(at(document, "run", "mandrel")),
        "no_load_run": text(at(document, "no_load_run", "id")),
        "method": text(at(document, "headline", "method")),
        "torque_nm": number(at(found, "value")),
        **_uncertainty(found),
        "raw_peak_nm": number(at(document, "headline", "raw_peak", "value")),
        "failed_checks": None if document is None else failed,
    }


def points(document: object) -> list[Row]:
    """Return a row for each set-point: the raw peak, and the torque by the primary method."""
    method = at(document, "headline", "method")
    # By set and found frequency; a sweep may come back to one.
    compensated: dict[tuple[float | None, float | None], list[Row]] = {}
    for each in rows(at(document, "compensations", str(method), "points")):
        compensated.setdefault(_frequencies(each), []).append(each)
    return [
        {
            "number": order,
            "recording": text(at(each, "recording")),
            "set_frequency_hz": number(at(each, "set_frequency", "value")),
            "frequency_hz": number(at(each, "frequency", "value")),
            "load_n": number(at(each, "load", "value")),
            "cycles": whole(at(each, "raw_peak", "cycles_kept")),
            "raw_peak_nm": number(at(each, "raw_peak", "mean", "value")),
            "raw_peak_sd_nm": number(at(each, "raw_peak", "standard_deviation", "value")),
            **_torque(compensated, each),
        }
        for order, each in enumerate(rows(at(document, "points")), 1)
    ]


def figures(document: object, zeros: Mapping[str, tuple[float, str]]) -> list[Row]:
    """Return what a run found of its rig: parameters of compensations, fits, zero readings."""
    found = [
        _figure("zero", name, {"value": value, "unit": unit})
        for name, (value, unit) in zeros.items()
    ]
    for source, each in named(at(document, "compensations")):
        found += [_figure(source, name, one) for name, one in named(each.get("parameters"))]
    for each in rows(at(document, "fits")):
        dof = at(each, "curve", "degrees_of_freedom")
        found += [
            _figure(f"fit {each.get('name')}", name, {**one, "degrees_of_freedom": dof})
            for name, one in named(at(each, "curve", "coefficients"))
        ]
    return list({(each["source"], each["name"]): each for each in found}.values())


def decision(found: object) -> Row:
    """Return the columns of a decision, the run's own or a later one."""
    return {
        "verdict": text(at(found, "verdict")),
        "rule": text(at(found, "rule")),
        "limit_text": text(at(found, "limit")),
        "limit_source": text(at(found, "limit_source")),
        "probability_of_conformity": number(at(found, "probability_of_conformity")),
        "reason": text(at(found, "reason")),
    }


def _uncertainty(found: object) -> Row:
    return {
        "u_nm": number(at(found, "standard_uncertainty")),
        "expanded_nm": number(at(found, "expanded_uncertainty_95")),
        "dof": degrees_of_freedom(at(found, "degrees_of_freedom")),
    }


def _torque(compensated: Mapping[Any, list[Row]], point: Row) -> Row:
    """Return the torque of the compensated point that is of this one."""
    found = compensated.get(_frequencies(point))
    torque = at(found.pop(0), "torque") if found else None
    return {"torque_nm": number(at(torque, "value")), **_uncertainty(torque)}


def _frequencies(point: Row) -> tuple[float | None, float | None]:
    return (
        number(at(point, "set_frequency", "value")),
        number(at(point, "frequency", "value")),
    )


def _figure(source: str, name: str, found: Row) -> Row:
    return {
        "source": key(source),
        "name": key(name),
        "value": number(found.get("value")),
        "u": number(found.get("standard_uncertainty")),
        "dof": degrees_of_freedom(found.get("degrees_of_freedom")),
        "unit": text(found.get("unit")),
    }
