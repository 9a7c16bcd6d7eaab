"""GUM (JCGM 100:2008) H.3: calibration of a thermometer by a straight line."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest

from helpers_cli import call
from rigrunner.api.data import Points
from rigrunner_plugins.fits.polynomial import PolynomialFit
from rigrunner_plugins.fits.settings import PolynomialSettings

T0 = 20.0
READING = [
    21.521, 22.012, 22.512, 23.003, 23.507, 23.999, 24.513, 25.002, 25.503, 26.010, 26.511,
]  # fmt: skip
CORRECTION = [
    -0.171, -0.169, -0.166, -0.159, -0.164, -0.165, -0.156, -0.157, -0.159, -0.161, -0.160,
]  # fmt: skip


@pytest.fixture
def line():
    points = Points(np.array(READING) - T0, np.array(CORRECTION), x_unit="°C", y_unit="°C")
    return PolynomialFit(PolynomialSettings(degree=1))(points)


def test_coefficients_of_the_line(line):
    u = np.sqrt(np.diag(line.covariance))
    assert line.coefficients == pytest.approx([-0.1712037901313500, 0.0021826977398873], rel=1e-12)
    assert u == pytest.approx([0.0028775978351600, 0.0006679387732278], rel=1e-12)
    assert line.covariance[0, 1] / u.prod() == pytest.approx(-0.9304296030934, abs=1e-12)
    assert line.residual_s == pytest.approx(0.003497563963505, rel=1e-12)
    assert line.dof == 9


def test_extrapolated_correction_at_30_degrees(line):
    """The GUM extrapolates; our curves refuse to, so the parts are combined here."""
    value, spread = line.value_and_spread(np.array([30.0 - T0]))
    assert value[0] == pytest.approx(-0.1493768127, abs=5e-11)
    assert np.linalg.norm(spread) == pytest.approx(0.0041385958, abs=5e-11)


STATION = """\
rigrunner: station/1
id: gum_h3
title: Table H.6 of the GUM
devices:
  bath:
    type: thermometer_bath
    plugin: tabulated
    settings:
      title: GUM H.3, table H.6
      set_points: [reading]
      rows:
{rows}
instruments:
  - {{channel: bath.correction, measures: temperature, serial: H-3, calibration: recorded,
     accuracy: {{drift: 0 K}}}}
"""
PROCEDURE = """\
rigrunner: procedure/2
id: GUM-H3
revision: "A"
title: Calibration of a thermometer by a straight line
inputs: {{specimen: {{ask: Serial number, unattended: H-3}}}}
uses: {{bath: thermometer_bath}}
main:
  - sweep:
      set: bath.reading
      over: [{over}]
      steps:
        - measure: {{channels: [bath.correction]}}
analysis:
  - curve:
      of: bath.correction
      over: bath.reading
      reference: 20 °C
      fit: {{polynomial: {{degree: 1}}}}
      results:
        parameters:
          c0: {{name: intercept, symbol: y1, unit: K}}
          c1: {{name: rise, symbol: y2, unit: K/K}}
        value: {{name: correction, symbol: b, unit: K, at: 30 °C, extrapolate: yes}}
"""


@pytest.fixture(scope="module")
def document(tmp_path_factory):
    folder = tmp_path_factory.mktemp("h3")
    pairs = zip(READING, CORRECTION, strict=True)
    rows = "\n".join(f"        - {{reading: {t} °C, correction: {b} K}}" for t, b in pairs)
    (folder / "station.yaml").write_text(STATION.format(rows=rows), encoding="utf-8")
    over = ", ".join(f"{t} °C" for t in READING)
    (folder / "h3.yaml").write_text(PROCEDURE.format(over=over), encoding="utf-8")
    output = call(
        "run", folder / "h3.yaml", "--station", folder / "station.yaml", "--unattended",
        "--runs", folder / "runs",
    )  # fmt: skip
    assert output.code == 0, output.err
    (run,) = (folder / "runs").iterdir()
    assert call("verify", run).code == 0
    return json.loads((run / "result.json").read_text(encoding="utf-8"))


def test_every_published_digit(document):
    """H.3.3 and H.3.4: y1 -0.1712(29) K, y2 0.00218(67), r -0.930, b(30 °C) -0.1494(41) K, nu 9."""
    estimates = {result["name"]: result["estimate"] for result in document["results"]}
    digits = {
        "intercept": (-0.1712037901313500, 0.0028775978351600),
        "rise": (0.0021826977398873, 0.0006679387732278),
        "correction": (-0.1493768127, 0.0041385958),
    }
    for name, (value, u) in digits.items():
        assert estimates[name]["value"] == pytest.approx(value, rel=1e-9)
        assert estimates[name]["standard_uncertainty"] == pytest.approx(u, rel=2e-8)
        assert estimates[name]["degrees_of_freedom"] == pytest.approx(9)
    notes = " ".join(document["notes"])
    (r,) = re.findall(r"Correlation of intercept and rise: (\S+)\.(?:\s|$)", notes)
    assert float(r) == pytest.approx(-0.9304296030934, abs=1e-6)


def test_value_outside_calibrated_range_is_marked(document):
    assert any("30 °C is outside the points, 21.521 to 26.511 °C" in note
               for note in document["notes"])  # fmt: skip
