"""A study of coverage as tables of text and as a document."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from rigrunner_bearings.study.coverage import METHODS
from rigrunner_bearings.study.tables import Table

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    from rigrunner_bearings.study.coverage import Row, Stratum, Study
    from rigrunner_bearings.study.share import Clustered, Share
    from rigrunner_bearings.study.tables import Part

WITH, WITHOUT = "with sensor term", "without sensor term"
ROW_HEADER = (
    "method", "rigs of", "sensor", "bias", "RMSE", "P95", "P99", "max", "error/u",
    "points held", "runs held",
)  # fmt: skip
FREQUENCY_HEADER = ("method", "sensor", "f / Hz", "bias", "RMSE", "P99", "max", "held")
MILLI = 1000.0


def main_rows(study: Study) -> list[list[str]]:
    """Return the rows of every method and simulator, in the order of ROW_HEADER; mN·m."""
    return [_row(row) for row in study.rows]


def law_rows(study: Study) -> list[list[str]]:
    """Return the same of the primary method by the bearing's law of friction."""
    return [_row(row) for row in study.laws]


def frequency_rows(study: Study) -> list[list[str]]:
    """Return one row per method and frequency, in the order of FREQUENCY_HEADER; mN·m."""
    return [
        [
            s.method,
            _sensor(s.sensor),
            f"{s.frequency_hz:g}",
            *_millis(s.error.bias, s.error.rms, s.error.p99, s.error.largest),
            coverage_text(s.coverage),
        ]
        for s in study.frequencies
    ]


def stratum_rows(study: Study, method: str, *, sensor: bool) -> list[list[str]]:
    """Return the coverage of one method, bands of resonance down and frequencies across."""
    strata = [s for s in study.strata if s.method == method and s.sensor is sensor]
    bands = dict.fromkeys(stratum.band_hz for stratum in strata)
    return [
        [band_text(band), *(coverage_text(s.coverage) for s in strata if s.band_hz == band)]
        for band in bands
    ]


def stratum_header(study: Study) -> list[str]:
    """Return the header of these rows."""
    frequencies = dict.fromkeys(stratum.frequency_hz for stratum in study.strata)
    return ["fn / Hz", *(f"{frequency_hz:g} Hz" for frequency_hz in frequencies)]


def printed(study: Study) -> Iterator[Part]:
    """Yield the printed parts: a summary, and every table."""
    yield summary(study)
    title = "Errors in mN·m, and how often the interval holds the truth"
    yield _table(title, ROW_HEADER, main_rows(study), words=3)
    yield _table("By the bearing's law of friction", ROW_HEADER, law_rows(study), words=3)
    yield _table("By frequency", FREQUENCY_HEADER, frequency_rows(study), words=2)
    for method in METHODS:
        for sensor in (True, False):
            title = f"By resonance and frequency: {method}, {_sensor(sensor)}"
            rows = stratum_rows(study, method, sensor=sensor)
            yield _table(title, stratum_header(study), rows, words=1)


def _table(
    title: str, header: Sequence[str], rows: Sequence[Sequence[str]], *, words: int
) -> Table:
    """Return a table whose first `words` columns are words, the others numbers."""
    sides = "l" * words + "r" * (len(header) - words)
    return Table(title=title, header=header, rows=rows, sides=sides)


def summary(study: Study) -> str:
    """Return the number of rigs in one sentence."""
    refused = f"; {study.refused} more were refused" if study.refused else ""
    return f"{study.rigs} rigs, half of each simulator{refused}."


def coverage_text(share: Share | Clustered) -> str:
    """Return '95.1 % (93.0-97.0)'."""
    low, high = share.interval
    return f"{100 * share.rate:.1f} % ({100 * low:.1f}-{100 * high:.1f})"


def band_text(band_hz: tuple[float, float]) -> str:
    """Return '200-300'."""
    return f"{band_hz[0]:g}-{band_hz[1]:g}"


def _row(row: Row) -> list[str]:
    error = row.error
    return [
        row.method,
        f"{row.simulator} ({row.rigs})",
        _sensor(row.sensor),
        *_millis(error.bias, error.rms, error.p95, error.p99, error.largest),
        f"{row.error_over_u:.2f}",
        coverage_text(row.coverage),
        coverage_text(row.mean_coverage),
    ]


def _sensor(with_it: bool) -> str:  # noqa: FBT001  (a field)
    return WITH if with_it else WITHOUT


def _millis(*values_nm: float) -> list[str]:
    return [f"{MILLI * value:.1f}" for value in values_nm]


def study_document(study: Study) -> dict[str, Any]:
    """Return the study as JSON has it, in N·m."""
    return {
        "rigs": study.rigs,
        "refused": study.refused,
        "methods": [_row_document(row) for row in study.rows],
        "laws": [_row_document(row) for row in study.laws],
        "frequencies": _stratum_documents(study.frequencies),
        "strata": _stratum_documents(study.strata),
    }


def _row_document(row: Row) -> dict[str, Any]:
    return {
        "method": row.method,
        "rigs_of": row.simulator,
        "sensor_term": row.sensor,
        "rigs": row.rigs,
        "error_nm": asdict(row.error),
        "error_over_u": row.error_over_u,
        "points_held": {
            "rate": row.coverage.rate,
            "of": row.coverage.of,
            "effective": row.coverage.effective,
            "interval_95": list(row.coverage.interval),
        },
        "runs_held": row.mean_coverage.document(),
    }


def _stratum_documents(strata: Iterable[Stratum]) -> list[dict[str, Any]]:
    return [
        {
            "method": stratum.method,
            "sensor_term": stratum.sensor,
            "natural_hz": list(stratum.band_hz),
            "frequency_hz": stratum.frequency_hz,
            "held": stratum.coverage.document(),
            "error_nm": asdict(stratum.error),
        }
        for stratum in strata
    ]
