"""What an archive keeps of a result: its set-points, the rig's figures, and the decision."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rigrunner_fleet.archive.documents import (
    at,
    count,
    degrees_of_freedom,
    key,
    mappings,
    number,
    rows,
    text,
)

if TYPE_CHECKING:
    from collections.abc import Mapping

Row = dict[str, Any]


def headline(document: object) -> Row:
    """Return the columns of a run with its result."""
    torque = at(document, "headline", "compensated")
    checks = [*rows(at(document, "checks"))]
    for _, compensation in mappings(at(document, "compensations")):
        checks += rows(compensation.get("checks"))
    failed = sum(check.get("ok") is False for check in checks)
    return {
        "measurand": text(at(document, "measurand", "name")),
        "symbol": text(at(document, "measurand", "symbol")),
        "mandrel": text(at(document, "run", "mandrel")),
        "no_load_run": text(at(document, "no_load_run", "id")),
        "method": text(at(document, "headline", "method")),
        "torque_nm": number(at(torque, "value")),
        **_uncertainty(torque),
        "raw_peak_nm": number(at(document, "headline", "raw_peak", "value")),
        "failed_checks": None if document is None else failed,
    }


def points(document: object) -> list[Row]:
    """Return a row for each set-point: the raw peak, and the torque by the primary method."""
    method = at(document, "headline", "method")
    # By set and found frequency; a sweep may come back to one.
    compensated: dict[tuple[float | None, float | None], list[Row]] = {}
    for point in rows(at(document, "compensations", str(method), "points")):
        compensated.setdefault(_frequencies(point), []).append(point)
    return [
        {
            "number": order,
            "recording": text(at(point, "recording")),
            "set_frequency_hz": number(at(point, "set_frequency", "value")),
            "frequency_hz": number(at(point, "frequency", "value")),
            "load_n": number(at(point, "load", "value")),
            "cycles": count(at(point, "raw_peak", "cycles_kept")),
            "raw_peak_nm": number(at(point, "raw_peak", "mean", "value")),
            "raw_peak_sd_nm": number(at(point, "raw_peak", "standard_deviation", "value")),
            **_torque(compensated, point),
        }
        for order, point in enumerate(rows(at(document, "points")), 1)
    ]


def figures(document: object, zeros: Mapping[str, tuple[float, str]]) -> list[Row]:
    """Return the figures of the rig from a run: compensation parameters, fits, zero readings."""
    figure_rows = [
        _figure("zero", name, {"value": value, "unit": unit})
        for name, (value, unit) in zeros.items()
    ]
    for source, entry in mappings(at(document, "compensations")):
        figure_rows += [
            _figure(source, name, figure) for name, figure in mappings(entry.get("parameters"))
        ]
    for entry in rows(at(document, "fits")):
        dof = at(entry, "curve", "degrees_of_freedom")
        figure_rows += [
            _figure(f"fit {entry.get('name')}", name, {**coefficient, "degrees_of_freedom": dof})
            for name, coefficient in mappings(at(entry, "curve", "coefficients"))
        ]
    return list({(row["source"], row["name"]): row for row in figure_rows}.values())


def decision(document: object) -> Row:
    """Return the columns of a decision, the run's own or a later one."""
    return {
        "verdict": text(at(document, "verdict")),
        "rule": text(at(document, "rule")),
        "limit_text": text(at(document, "limit")),
        "limit_source": text(at(document, "limit_source")),
        "probability_of_conformity": number(at(document, "probability_of_conformity")),
        "reason": text(at(document, "reason")),
    }


def _uncertainty(torque: object) -> Row:
    return {
        "u_nm": number(at(torque, "standard_uncertainty")),
        "expanded_nm": number(at(torque, "expanded_uncertainty_95")),
        "dof": degrees_of_freedom(at(torque, "degrees_of_freedom")),
    }


def _torque(compensated: Mapping[Any, list[Row]], point: Row) -> Row:
    """Return the torque of the compensated point that is of this one."""
    points = compensated.get(_frequencies(point))
    torque = at(points.pop(0), "torque") if points else None
    return {"torque_nm": number(at(torque, "value")), **_uncertainty(torque)}


def _frequencies(point: Row) -> tuple[float | None, float | None]:
    return (
        number(at(point, "set_frequency", "value")),
        number(at(point, "frequency", "value")),
    )


def _figure(source: str, name: str, parameter: Row) -> Row:
    return {
        "source": key(source),
        "name": key(name),
        "value": number(parameter.get("value")),
        "u": number(parameter.get("standard_uncertainty")),
        "dof": degrees_of_freedom(parameter.get("degrees_of_freedom")),
        "unit": text(parameter.get("unit")),
    }
