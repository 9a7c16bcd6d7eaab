"""What a result document says, as rows and plots."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from rigrunner.archive import Rows
from rigrunner.archive.documents import at, number
from rigrunner.archive.named_results import named_results
from rigrunner.archive.result_facts import figures, points
from rigrunner.archive.schema import FIGURES, POINTS, RESULTS
from rigrunner.plots import torque_over_frequency

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
    """Return what was found of the rig, with the columns of the archive's `figures`."""
    return _rows(FIGURES, figures(document, {}))


def plot_of(document: Document | None, title: str) -> Plot:
    """Return raw and compensated torque over frequency, with the limits."""
    found = points_of(document)
    columns = [
        np.array([np.nan if value is None else value for value in found.column(name)], float)
        for name in ("frequency_hz", "raw_peak_nm", "torque_nm", "expanded_nm")
    ]
    ends = (at(document, "decision", name, "value") for name in ("lower_limit", "upper_limit"))
    limits = [limit for end in ends if (limit := number(end)) is not None]
    return torque_over_frequency(*columns, title=title, limits_nm=limits)


def _rows(table: Table, every: list[Mapping[str, Any]] | list[dict[str, Any]]) -> Rows:
    kinds = {each.name: each.type.python_type for each in table.c if each.name != "run"}
    values = tuple(tuple(row[name] for name in kinds) for row in every)
    return Rows(table=table.name, columns=kinds, values=values)
