"""A station whose one device is a table: a resistance at 0 °C and at 100 °C."""

from __future__ import annotations

import pytest

from helpers_cli import call

STATION = """\
rigrunner: station/1
id: bench
title: A table
devices:
  bench:
    type: table
    plugin: tabulated
    settings:
      title: written down
      set_points: [temperature]
      rows:
        - {temperature: 0 °C, resistance: 100.0 Ω}
        - {temperature: 100 °C, resistance: 138.5 Ω}
instruments:
  - {channel: bench.resistance, measures: resistance, serial: R-1, calibration: recorded,
     accuracy: 5 mΩ}
"""


@pytest.fixture
def checked(tmp_path):
    """Give the function that checks the text of a procedure on that station."""

    def check(procedure):
        (tmp_path / "station.yaml").write_text(STATION, encoding="utf-8")
        (tmp_path / "p.yaml").write_text(procedure, encoding="utf-8")
        return call("check", tmp_path / "p.yaml", "--station", tmp_path / "station.yaml")

    return check
