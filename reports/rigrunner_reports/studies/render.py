"""Render a study as one self-contained HTML file."""

from __future__ import annotations

from collections import Counter
from functools import partial
from typing import TYPE_CHECKING, Any

from rigrunner.api.studies import CapabilityStudy, GaugeStudy, GoldenStudy, Trend
from rigrunner_reports.numbers import as_scattered, fixed, percent, significant, with_sign
from rigrunner_reports.render import fill
from rigrunner_reports.studies.control_chart import control_chart
from rigrunner_reports.studies.golden import MOST_RUNS, in_u, shifts
from rigrunner_reports.studies.pictures import components, distribution, letter, readings

if TYPE_CHECKING:
    from rigrunner.api import StudyInput

TITLES = {
    Trend: ("Trend", "trend.html.j2"),
    CapabilityStudy: ("Capability", "capability.html.j2"),
    GaugeStudy: ("Gauge repeatability and reproducibility", "gauge.html.j2"),
    GoldenStudy: ("Golden runs", "golden.html.j2"),
}
MOST_LISTED = 60
"""Alarms of a chart that are listed."""


def html(study: StudyInput) -> bytes:
    """Return the report as UTF-8; the same study gives the same bytes."""
    title, template = TITLES[type(study)]
    return fill(
        template,
        study=study,
        title=f"{title}: {study.quantity}",
        reasons=Counter(run.reason for run in study.excluded).most_common(),
        most_listed=MOST_LISTED,
        **_figures(study),
        scattered=as_scattered,
        percent=percent,
        fixed=fixed,
        significant=significant,
    )


def _figures(study: StudyInput) -> dict[str, Any]:
    if isinstance(study, Trend):
        return {"chart": partial(control_chart, study)}
    if isinstance(study, CapabilityStudy):
        return {"chart": partial(distribution, study)}
    if isinstance(study, GoldenStudy):
        picture = shifts(study) if study.shifts_in_u else None
        return {"picture": picture, "in_u": in_u, "with_sign": with_sign, "most_runs": MOST_RUNS}
    return {"readings": readings(study), "components": components(study), "letter": letter}
