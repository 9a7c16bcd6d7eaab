"""The shipped procedure of a platinum sensor, on a chamber and an ohmmeter over SCPI."""

from __future__ import annotations

import json
import re
from math import sqrt

import pytest

from helpers_cli import call
from rigrunner.workflow.locate import find_procedure
from rigrunner_plugins.loopback.chamber import DEVIATION_K, platinum, running_chamber

pytestmark = pytest.mark.in_real_time

TEMPERATURES_C = (-20.0, 0.0, 50.0, 100.0)
PROCEDURE = find_procedure("resistance_over_temperature")
NOMINAL_OHM = {-20.0: 92.16, 0.0: 100.00, 50.0: 119.40, 100.0: 138.51}
"""As printed in IEC 60751:2022, table 1."""


@pytest.fixture(scope="module")
def tested(tmp_path_factory):
    folder = tmp_path_factory.mktemp("rtd")
    with running_chamber() as bench:
        (folder / "station.yaml").write_text(bench.station(), encoding="utf-8")
        called = call(
            "run", PROCEDURE, "--station", folder / "station.yaml", "--unattended", "--runs",
            folder / "runs",
        )  # fmt: skip
    assert called.code == 0, called.err
    (found,) = (folder / "runs").iterdir()
    return found, json.loads((found / "result.json").read_text(encoding="utf-8"))


@pytest.mark.parametrize("celsius", TEMPERATURES_C)
def test_the_loopback_sensor_is_the_standard_s(celsius):
    assert platinum(celsius) == pytest.approx(NOMINAL_OHM[celsius], abs=0.005)


def test_the_limits_are_class_b(tested):
    """Tolerance of the standard, ±(0.30 + 0.005 |t|) °C, by its slope dR/dt, at each point."""
    parts = {each["of"]: each for each in tested[1]["decision"]["parts"]}
    for t in TEMPERATURES_C:
        slope = 100 * (3.9083e-3 - 2 * 5.775e-7 * t)  # the term of t³ moves it by 1e-4 at -20 °C
        tolerance = (0.30 + 0.005 * abs(t)) * slope
        part = parts[f"resistance at chamber.temperature = {t:g} °C"]
        assert part["lower_limit"]["value"] == pytest.approx(platinum(t) - tolerance, abs=2e-3)
        assert part["upper_limit"]["value"] == pytest.approx(platinum(t) + tolerance, abs=2e-3)


def test_each_resistance_is_found_with_its_uncertainty(tested):
    found = [each for each in tested[1]["results"] if each["name"] == "resistance"]
    at = [each["coordinates"]["chamber.temperature"] for each in found]
    assert at == [{"value": t, "unit": "°C"} for t in TEMPERATURES_C]
    for each, t in zip(found, TEMPERATURES_C, strict=True):
        estimate = each["estimate"]
        assert estimate["unit"] == "Ω"
        assert estimate["value"] == pytest.approx(platinum(t + DEVIATION_K), abs=0.02)
        assert estimate["standard_uncertainty"] > 0.010 / sqrt(3)
        assert each["readings"] == 5
        assert [line["name"] for line in each["budget"]] == [
            "scatter of the readings", "reading of meter.resistance",
        ]  # fmt: skip


def test_it_passes_and_the_report_shows_each_point_with_its_limit(tested):
    folder, document = tested
    assert document["verdict"]["verdict"] == "pass"
    page = (folder / "report.html").read_text(encoding="utf-8")
    assert "resistance of the sensor" in page
    assert len(re.findall(r"119\.186\sΩ to 119\.608\sΩ", page)) >= 1
    assert call("verify", folder).code == 0
