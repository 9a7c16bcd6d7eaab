"""The page of the coverage study has the population of the code, and tables of one study."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from rigrunner_bearings.study import coverage_rigs as rigs
from rigrunner_bearings.study.coverage import limits
from rigrunner_bearings.study.coverage_plots import FIGURES
from rigrunner_bearings.study.coverage_rigs import FREQUENCIES_HZ, torque_instrument
from rigrunner_bearings.study.coverage_table import ROW_HEADER, coverage_text
from rigrunner_bearings.study.populations import PAUSE_S
from rigrunner_bearings.study.share import Share
from rigrunner_bearings.study.tools import tools

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigrunner.api.instruments import Instrument
    from rigrunner_bearings.study.bench import Range
    from rigrunner_bearings.study.coverage_rigs import Limits

HEADER = ("rigs of", "quantity", "from", "to", "unit")
BOTH = "both"
MINUTE_S = 60.0


def population_rows(instrument: Instrument, limits: Limits) -> list[list[str]]:
    """Return what is drawn evenly between which values, in the order of HEADER."""
    return [
        *(_range(BOTH, each) for each in rigs.COMMON),
        *(_range(name, each) for name, ranges in rigs.RANGES.items() for each in ranges),
        *_measuring(),
        *_stated(instrument, limits),
    ]


def law_rows() -> list[list[str]]:
    """Return the laws of friction of each simulator, each as likely as the others."""
    return [[name, ", ".join(laws)] for name, laws in rigs.LAWS.items()]


def _range(simulator: str, each: Range) -> list[str]:
    unit = f"times {each.times}" if each.times else each.unit
    return [simulator, each.setting, f"{each.low:g}", f"{each.high:g}", unit]


def _measuring() -> Iterator[list[str]]:
    low, high = rigs.CYCLES
    yield [BOTH, "cycles of a recording", str(low), str(high), "1"]
    low_hz, high_hz = rigs.CORNER_HZ
    yield [BOTH, "low-pass corner, as registered", f"{low_hz:g}", f"{high_hz:g}", "Hz"]
    low_s, high_s = PAUSE_S
    yield [BOTH, "pause between the runs", f"{low_s / MINUTE_S:g}", f"{high_s / MINUTE_S:g}", "min"]


def _stated(instrument: Instrument, limits: Limits) -> Iterator[list[str]]:
    """Yield what the budget states: the register's limits, and those of the methods' settings."""
    limit = instrument.half_width
    drift = "zero drift, in the long run"
    yield _either_way("sensor gain error", 100 * limit("gain"), "%")
    yield _either_way("sensor offset", limit("offset"), "N·m")
    yield _either_way(drift, limit("drift"), "N·m")
    yield _either_way(
        "sensor non-linearity",
        100 * limit("nonlinearity") / instrument.full_scale,
        "% of full scale",
    )
    yield _either_way("low-pass corner against the register", 100 * limits.low_pass_tolerance, "%")
    yield _either_way("inertia under load", 100 * limits.inertia_mismatch, "%")
    yield _either_way("load", 100 * limits.load_tolerance, "%")
    yield _either_way("support friction under load", 100 * limits.support_load_dependence, "%")


def _either_way(quantity: str, limit: float, unit: str) -> list[str]:
    return [BOTH, quantity, f"{-limit:g}", f"{limit:g}", unit]


pytestmark = pytest.mark.figures

DOCS = Path(__file__).parents[2] / "docs"
PAGE = (DOCS / "evidence/coverage.md").read_text(encoding="utf-8")


def rows_after(words):
    """Return the first table after these words."""
    table = re.search(r"(?:^\|.*\n)+", PAGE.split(words, 1)[1], re.MULTILINE)
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in table[0].splitlines()]


def test_the_population_is_that_of_the_code():
    header, _, *rows = rows_after("## The rigs")
    assert header == list(HEADER)
    assert rows == population_rows(torque_instrument(tools().station), limits())
    assert f"at {', '.join(f'{f:g}' for f in FREQUENCIES_HZ)} Hz" in PAGE


def test_the_laws_are_those_of_the_code():
    assert rows_after("follows one of these laws")[2:] == law_rows()


def test_every_figure_is_there():
    for name in FIGURES:
        assert f"../images/{name}.svg" in PAGE
        assert (DOCS / f"images/{name}.svg").exists()


@pytest.mark.parametrize("title", ["Errors in mN·m, and how", "By the bearing's law"])
def test_intervals_of_runs_belong_to_their_counts(title):
    header, _, *rows = rows_after(f"### {title}")
    assert header == list(ROW_HEADER)
    for row in rows:
        rigs = int(re.search(r"\((\d+)\)", row[1])[1])
        rate = float(row[-1].split(" %")[0]) / 100
        assert coverage_text(Share(round(rate * rigs), rigs)) == row[-1]
