"""A power supply on a bench, written down: what it gives is known exactly."""

from __future__ import annotations

STATION = """\
rigrunner: station/1
id: bench
title: Power supply on a bench
devices:
  bench:
    type: supply_bench
    plugin: tabulated
    settings:
      title: a supply, written down
      set_points: [current]
      rows:
        - {current: 0 A, voltage: 12.031 V, ripple: 3 mV}
        - {current: 1 A, voltage: 12.022 V, ripple: 4 mV}
        - {current: 2 A, voltage: 12.014 V, ripple: 6 mV}
        - {current: 5 A, voltage: 11.987 V, ripple: 9 mV}
instruments:
  - {channel: bench.voltage, measures: voltage, serial: DMM-1, calibration: recorded,
     accuracy: 2 mV}
"""
PROCEDURE = """\
rigrunner: procedure/2
id: PSU-REG
revision: "A"
title: Load regulation of a power supply
inputs: {specimen: {ask: Serial number, unattended: PSU-1}}
uses: {bench: supply_bench}
main:
  - sweep:
      set: bench.current
      over: [0 A, 1 A, 2 A, 5 A]
      steps:
        - measure: {channels: [bench.voltage, bench.ripple]}
analysis:
  - readings:
      of: bench.voltage
      per: bench.current
      result: {name: voltage, symbol: U, text: output voltage, unit: V}
  - readings:
      of: bench.voltage
      statistic: range
      result: {name: regulation, text: load regulation, unit: mV, id: voltage.regulation}
acceptance:
  rule: guard_band_u
  limits:
    - {of: voltage, each: bench.current, min: 11.98 V, max: 12.1 V, source: data sheet}
    - {of: regulation, max: 50 mV, source: data sheet}
"""


def written(folder, *changes, procedure=PROCEDURE, station=STATION):
    """Write procedure and station, with changes of the procedure; return their paths."""
    for old, new in changes:
        assert old in procedure, old
        procedure = procedure.replace(old, new)
    folder.mkdir(exist_ok=True, parents=True)
    (folder / "supply.yaml").write_text(procedure, encoding="utf-8")
    (folder / "station.yaml").write_text(station, encoding="utf-8")
    return folder / "supply.yaml", folder / "station.yaml"
