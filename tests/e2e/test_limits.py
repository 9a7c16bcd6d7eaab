"""Values out of their limits: in table, file, digest, `show`, result, report and exit code."""

from __future__ import annotations

import json

import h5py
import numpy as np
import pytest

from helpers_cli import call
from rigrunner.runfile import read

pytestmark = pytest.mark.usefixtures("without_pdf")

PROCEDURE = """\
rigrunner: procedure/2
id: LIMITS
revision: "A"
title: Load cell, within limits
measurand: {symbol: Tr, name: torque at rest, unit: N·m}
uses: {tester: swing_tester}
main:
  - sweep:
      set: tester.load
      over: [200 N, 500 N, 1000 N]
      steps:
        - measure:
            channels: [tester.load, tester.torque]
            name: cell
            limits: {tester.load: {max: 100 N}, tester.torque: {max: 1 N·m}}
            on_fail: continue
  - set: {tester.load: 50 N}
teardown:
  - set: {tester.load: 0 N}
"""
STOPS = ("on_fail: continue", "on_fail: stop")
WITHIN = ("{max: 100 N}", "{max: 2 kN}")


def run(folder, *changes, code):
    text = PROCEDURE
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    folder.mkdir(exist_ok=True)
    (folder / "limits.yaml").write_text(text, encoding="utf-8")
    called = call(
        "run", folder / "limits.yaml", "--station", "simulated", "--unattended",
        "--runs", folder / "runs",
    )  # fmt: skip
    assert called.code == code, called.err
    (folder_of_run,) = (folder / "runs").glob("*LIMITS*")
    return called, folder_of_run


@pytest.fixture(scope="module")
def failed(tmp_path_factory):
    return run(tmp_path_factory.mktemp("failed"), code=1)


def test_values_out_of_limits_have_limit_and_verdict(failed):
    stored = read(failed[1])
    assert stored.info.outcome == "completed"
    decisions = [(row.setpoints["tester.load"], decision) for row in stored.measurements
              for decision in row.decisions]  # fmt: skip
    loads = [(at, decision.passes) for at, decision in decisions if decision.of == "tester.load"]
    assert loads == [(200.0, False), (500.0, False), (1000.0, False)]
    assert all(decision.passes for _, decision in decisions if decision.of == "tester.torque")
    assert {decision.limits.upper for _, decision in decisions} == {100.0, 1.0}


def test_limits_and_verdicts_are_columns_of_the_run_file(failed):
    with h5py.File(failed[1] / "run.h5") as file:
        table = file["entry/measurements/cell"]
        assert table["values/tester_load"][()] == pytest.approx([200, 500, 1000], rel=0.01)
        limit = table["limits/tester_load"]
        assert limit.attrs["name"] == "tester.load"
        assert list(limit["maximum"][()]) == [100.0] * 3
        assert np.isnan(limit["minimum"][()]).all()
        assert list(limit["passes"][()]) == [0, 0, 0]
        assert list(table["limits/tester_torque/passes"][()]) == [1, 1, 1]
        assert list(table["passes"][()]) == [0, 0, 0]
        assert file.attrs["rigrunner_format"] == 4


def test_digest_covers_values_and_limits(failed, tmp_path):
    """Runs with other values or other limits have other digests."""
    digests = {
        read(failed[1]).digest,
        read(run(tmp_path / "other", ("200 N, ", "300 N, "), code=1)[1]).digest,
        read(run(tmp_path / "limit", ("{max: 100 N}", "{max: 101 N}"), code=1)[1]).digest,
    }
    assert len(digests) == 3
    assert call("verify", failed[1]).code == 0


def test_show_prints_value_limit_and_verdict(failed):
    shown = call("show", failed[1]).out
    assert shown.count("FAIL: tester.load") == 3
    assert "tester.load: limit 100 N or less" in shown
    rows = json.loads(call("show", failed[1], "--json").out)["measurements"]
    assert [[limit["verdict"] for limit in row["limits"]] for row in rows] == [["fail", "pass"]] * 3


def test_result_and_report_have_missed_limits(failed):
    called, folder = failed
    assert "verdict  FAIL" in called.out
    document = json.loads((folder / "result.json").read_text(encoding="utf-8"))
    assert document["verdict"]["verdict"] == "fail"
    assert (document["limits"]["judged"], document["limits"]["missed"]) == (6, 3)
    assert [row["verdict"] for row in document["limits"]["values"]] == ["fail"] * 3 + ["pass"] * 3
    assert document["decision"] is None
    page = (folder / "report.html").read_text(encoding="utf-8")
    for row in read(folder).measurements:
        assert f"{row.values['tester.load']:.4g}\N{NO-BREAK SPACE}N</td>" in page
    assert page.count("100\N{NO-BREAK SPACE}N or less") >= 3
    assert 'class="verdict fail"' in page


def test_a_run_within_its_limits_passes(tmp_path):
    called, folder = run(tmp_path, WITHIN, code=0)
    assert "verdict  PASS" in called.out
    assert all(decision.passes for row in read(folder).measurements for decision in row.decisions)


def test_run_stopped_at_a_limit_is_sealed_and_reported(tmp_path):
    _, folder = run(tmp_path, STOPS, code=1)
    stored = read(folder)
    assert stored.info.outcome == "stopped at a limit"
    assert stored.info.reason == "tester.load is 199.8 N (limit: 100 N or less)"
    assert len(stored.measurements) == 1
    assert (folder / "report.html").exists()
    assert "Set tester.load to 0 N" in (folder / "run.log").read_text(encoding="utf-8")
    assert "stopped at a limit" in (folder / "report.html").read_text(encoding="utf-8")
    for command in ("analyse", "report"):
        assert call(command, folder).code in {0, 1}
    assert call("analyse", folder).code == 1
    resumed = call("resume", folder)
    assert resumed.code != 0
    assert "has ended and is sealed" in resumed.err


ORDER = (
    "--customer", "ACME", "--customer-contact", "1 Main St", "--item", "Load cell",
    "--item-id", "SN-1", "--item-condition", "new", "--received", "2026-01-31",
    "--operator", "A. Nother",
)  # fmt: skip


@pytest.fixture
def laboratory(tmp_path, monkeypatch):
    assert call("init", tmp_path / "lab").code == 0
    monkeypatch.chdir(tmp_path / "lab")
    return tmp_path / "lab"


def certified(folder, laboratory):
    called = call(
        "certify", folder, "--authorised-by", "B. Other", *ORDER,
        "--letterhead", laboratory / "letterhead", "--not-for-certification",
    )  # fmt: skip
    assert called.code == 0, called.err
    (page,) = folder.glob("SPECIMEN*.html")
    return json.loads(page.with_suffix(".json").read_text(encoding="utf-8")), page


@pytest.mark.parametrize(
    ("changes", "rows"), [((), 6), pytest.param((STOPS,), 2, marks=pytest.mark.thorough)]
)
def test_run_with_missed_limits_is_certified_as_fail(laboratory, changes, rows):
    _, folder = run(laboratory / "work", *changes, code=1)
    document, page = certified(folder, laboratory)
    measured = document["measured"]
    assert (document["results"], document["conformity"]) == (None, None)
    assert (measured["verdict"], len(measured["values"])) == ("fail", rows)
    first = measured["values"][0]
    assert (first["of"], first["printed_limit"], first["verdict"]) == (
        "tester.load", "≤ 100 N", "fail",
    )  # fmt: skip
    text = page.read_text(encoding="utf-8")
    for value in measured["values"]:
        assert value["printed"] in text
    stopped = [
        deviation
        for deviation in document["deviations"]
        if "Stopped at a limit" in deviation["text"]
    ]
    assert len(stopped) == len(changes)
    assert not [
        deviation for deviation in document["deviations"] if deviation["kind"] in {"alarm", "note"}
    ]
    verified = call("verify", page, "--letterhead", laboratory / "letterhead")
    assert (verified.code, "MATCH" in verified.out) == (0, True), verified.out


@pytest.mark.thorough
def test_certificate_with_a_changed_limit_does_not_match(laboratory):
    _, folder = run(laboratory / "work", code=1)
    _, page = certified(folder, laboratory)
    file = page.with_suffix(".json")
    file.chmod(0o644)
    text = file.read_text(encoding="utf-8")
    assert '"printed_limit": "≤ 100 N"' in text
    file.write_text(text.replace("≤ 100 N", "≤ 999 N"), encoding="utf-8")
    assert call("verify", file).code == 1


RECORDS = """\
rigrunner: procedure/2
id: LIMITS
revision: "A"
title: Torque of a swing, within limits
measurand: {symbol: T, name: torque of a swing, unit: N·m}
uses: {tester: swing_tester}
main:
  - set: {tester.load: 500 N, tester.frequency: 5 Hz}
  - settle: {cycles: 5}
  - record:
      channels: [tester.angle, tester.torque]
      cycles: 10
      limits:
        tester.torque:
          min: -9 N·m
          max: 600 mN·m
          mean: {min: -0.1 N·m, max: 0.1 N·m}
          peak_to_peak: {max: 1 N·m}
          rms: {max: 2 N·m}
        tester.load: {min: 490 N, max: 510 N}
teardown:
  - set: {tester.frequency: 0 Hz, tester.load: 0 N}
"""


def test_limits_on_the_samples_of_a_recording(tmp_path):
    (tmp_path / "limits.yaml").write_text(RECORDS, encoding="utf-8")
    called = call(
        "run", tmp_path / "limits.yaml", "--station", "simulated", "--unattended",
        "--runs", tmp_path / "runs",
    )  # fmt: skip
    assert called.code == 1, called.err
    (folder,) = (tmp_path / "runs").iterdir()
    stored = read(folder)
    assert stored.info.outcome == "stopped at a limit"
    (recording,), (row,) = stored.recordings, stored.measurements
    assert (row.name, row.recording) == ("recorded", recording.name)
    torque = np.asarray(recording.channels["tester.torque"])
    expected = {
        "tester.torque.minimum": torque.min(),
        "tester.torque.maximum": torque.max(),
        "tester.torque.mean": torque.mean(),
        "tester.torque.peak_to_peak": np.ptp(torque),
        "tester.torque.rms": np.sqrt(np.mean(torque**2)),
        "tester.load": recording.conditions["tester.load"],
    }
    assert dict(row.values) == {name: pytest.approx(value) for name, value in expected.items()}
    assert {decision.of: decision.passes for decision in row.decisions} == {
        "tester.torque.minimum": True,
        "tester.torque.maximum": False,
        "tester.torque.mean": True,
        "tester.torque.peak_to_peak": False,
        "tester.torque.rms": True,
        "tester.load": True,
    }
    assert set(row.units.values()) == {"N", "Hz", "N·m"}
    assert row.units["tester.torque.rms"] == "N·m"
    assert "tester.torque.maximum" in (folder / "report.html").read_text(encoding="utf-8")
    assert call("verify", folder).code == 0


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("mean:", "median:", "limits.tester.torque.median: unknown key 'median'"),
        ("600 mN·m", "600 N", "limits.tester.torque: '-9 N·m' is a torque, but '600 N' is a force"),
        ("rms: {max: 2 N·m}", "rms: {max: 2 N}", "torque.rms.max: got '2 N', a force"),
        ("tester.torque:\n", "tester.humidty:\n", "has no channel 'humidty'"),
        ("{min: 490 N, max: 510 N}", "{mean: {max: 5 N}}", "read once beside the recording"),
        ("rms:", "maximum:", "'max' and 'maximum' limit the same value"),
        ("peak_to_peak: {max: 1 N·m}", "peak_to_peak: {}", "a limit needs max, min, or both"),
        ("[tester.angle, tester.torque]", "[tester.angle]", "and has no mean"),
    ],
)
def test_check_refuses_invalid_limits_of_a_recording(tmp_path, old, new, told):
    assert RECORDS.count(old) == 1
    (tmp_path / "limits.yaml").write_text(RECORDS.replace(old, new), encoding="utf-8")
    checked = call("check", tmp_path / "limits.yaml", "--station", "simulated")
    assert checked.code == 3
    assert told in checked.err
    assert "limits.yaml:" in checked.err
