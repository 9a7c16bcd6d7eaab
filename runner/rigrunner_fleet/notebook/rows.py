"""Rows and plots of a result document."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from rigrunner.api.data import Estimate
from rigrunner.api.errors import UsageError
from rigrunner.api.figures import Axis, Figure, Mark, Picture, Series
from rigrunner.api.findings import MeasurementResult, ResultDefinition
from rigrunner.api.verdict import Limits, Verdict
from rigrunner.plots import draw
from rigrunner.run.set_points import coordinates_in
from rigrunner.signal.result_figures import over_coordinate
from rigrunner_fleet.archive import Rows
from rigrunner_fleet.archive.documents import at, degrees_of_freedom, number
from rigrunner_fleet.archive.named_results import named_results
from rigrunner_fleet.archive.result_facts import figures, points
from rigrunner_fleet.archive.schema import FIGURES, POINTS, RESULTS

if TYPE_CHECKING:
    from collections.abc import Mapping

    from sqlalchemy import Table

    from rigrunner.plots import Plot

Document = dict[str, Any]


def points_of(document: Document | None) -> Rows:
    """Return a row for each set-point, with the columns of the archive's `points`."""
    return _rows(POINTS, points(document))


def results_of(document: Document | None) -> Rows:
    """Return a row for each named result, with the columns of the archive's `results`."""
    return _rows(RESULTS, named_results(document, at(document, "decision")))


def figures_of(document: Document | None) -> Rows:
    """Return the figures of the rig, with the columns of the archive's `figures`."""
    return _rows(FIGURES, figures(document, {}))


def plot_of(document: Document | None, title: str) -> Plot:
    """Return raw and compensated torque over frequency, with the limits."""
    rows = [row for row in points_of(document) if row["frequency_hz"] is not None]
    raw, torque = (
        [row for row in rows if row[name] is not None] for name in ("raw_peak_nm", "torque_nm")
    )
    series = (
        Series.over(
            (row["frequency_hz"] for row in torque),
            (row["torque_nm"] for row in torque),
            "compensated, with U (95 %)",
            "joined",
            U=(np.nan if row["expanded_nm"] is None else row["expanded_nm"] for row in torque),
        ),
        Series.over(
            (row["frequency_hz"] for row in raw),
            (row["raw_peak_nm"] for row in raw),
            "raw peak",
            "joined",
        ),
    )
    ends = (at(document, "decision", name, "value") for name in ("lower_limit", "upper_limit"))
    limits = (limit for end in ends if (limit := number(end)) is not None)
    marks = tuple(Mark("y", limit, name="limit", is_limit=True) for limit in limits)
    axes = Axis("frequency", "Hz"), Axis("torque", "N·m")
    figure = Figure(title, *axes, tuple(line for line in series if line.points), marks)
    return draw(
        Picture("Raw and compensated torque over frequency.", title, (figure,)), titled=True
    )


def results_plot(document: Document | None, name: str) -> Plot:
    """Return the figures of the results of one name, as in a report.

    Raises UsageError if there is none of that name, or if it has no coordinate to plot it over.
    """
    rows = results_of(document)
    results = list(zip((document or {}).get("results") or (), rows, strict=True))
    limited = []
    for result, row in results:
        if result["name"] == name:
            limits = Limits.between(row["lower"], row["upper"], row["unit"])
            has_limit = row["lower"] is not None or row["upper"] is not None
            failed = row["verdict"] not in {None, Verdict.PASS}
            limited.append((_result(result), limits if has_limit else None, failed))
    if not limited:
        names = ", ".join(dict.fromkeys(result["name"] for result, _ in results)) or "none"
        raise UsageError(f"there is no result '{name}'", hint=f"there are: {names}")
    figures = over_coordinate(limited)
    if not figures:
        raise UsageError(f"'{name}' has no coordinate that is a number of several")
    title = figures[0].title
    return draw(Picture(title, title, figures), titled=True)


def _result(stored: Mapping[str, Any]) -> MeasurementResult:
    entry = stored["estimate"]
    definition = ResultDefinition(
        name=stored["name"],
        symbol=stored["symbol"] or "",
        text=stored["text"] or "",
        unit=entry["unit"],
    )
    u, dof = number(entry["standard_uncertainty"]), degrees_of_freedom(entry["degrees_of_freedom"])
    estimate = Estimate(
        entry["value"], np.nan if u is None else u, np.nan if dof is None else dof, entry["unit"]
    )
    return MeasurementResult(of=definition, estimate=estimate, coordinates=coordinates_in(stored))


def _rows(table: Table, records: list[Mapping[str, Any]] | list[dict[str, Any]]) -> Rows:
    kinds = {column.name: column.type.python_type for column in table.c if column.name != "run"}
    values = tuple(tuple(record[name] for name in kinds) for record in records)
    return Rows(table=table.name, columns=kinds, values=values)
