"""Partner runs, end to end: a third-party plugin, and `readings` with a tare, in YAML only."""

from __future__ import annotations

import json
from math import sqrt

import pytest

from helpers_certificate import make_letterhead
from helpers_cli import call
from rigrunner.runfile import read

pytestmark = pytest.mark.usefixtures("without_pdf")

PLUGIN = '''\
from rigrunner.api import (AnalysisRecord, Component, DataError, Estimate, Findings, Member,
    MeasurementResult, NeededChannel, PartnerRun, Requirements, ResultDefinition, Settings,
    hookimpl)
from rigrunner.signal.uncertainty import combine

api_version = 1
NET = ResultDefinition(name="net", text="net photocurrent", unit="V")

class NetSettings(Settings):
    of: Member
    """The signal."""
    dark: PartnerRun
    """The run with the shutter closed."""

class Net:
    def __init__(self, told):
        self.of = told.of
    def __call__(self, run):
        values, u = [], []
        for each in (run, run.partners["dark"]):
            found = [row.values[self.of] for row in each.measurements if self.of in row.values]
            if not found: raise DataError(f"{self.of} was not measured in {each.run_id}")
            values.append(sum(found) / len(found))
            u += [e.u for e in each.reading_errors(self.of, max(found))]
        lines = tuple(Component(f"reading {i}", x, float("inf"), "rectangular", True, unit="V")
                      for i, x in enumerate(u))
        estimate = Estimate(values[0] - values[1], *combine(lines), "V")
        return Findings(results=(MeasurementResult(of=NET, estimate=estimate, components=lines),))

@hookimpl
def rigrunner_analyses(): return [AnalysisRecord(
    name="net_signal", help="A signal less that of a dark run", settings=NetSettings, factory=Net,
    yields=lambda _: (NET,), requires=requires, trial_units={"diode.signal": "V"},
    trial={"of": "diode.signal", "dark": {"procedure": "DARK"}})]

def requires(told):
    needed = NeededChannel(name=told.of, key=("of",), enters=("net",))
    dark = told.dark.needed("dark", ("dark",), channels=(needed,))
    return Requirements(channels=(needed,), partners=(dark,))
'''
STATION = """\
rigrunner: station/1
id: optics
title: A photodiode before a lamp
plugins: plugins
rig: {mandrel: M-1}
devices:
  diode:
    type: photodiode
    plugin: tabulated
    settings:
      title: a photodiode, written down
      set_points: [lamp]
      rows:
        - {lamp: 0 A, signal: 0.012 V}
        - {lamp: 1 A, signal: 1.512 V}
        - {lamp: 2 A, signal: 3.012 V}
instruments:
  - {channel: diode.signal, measures: voltage, serial: DMM-1, calibration: recorded,
     accuracy: {offset: 5 mV}}
"""
HEAD = """\
rigrunner: procedure/2
id: ID
revision: "A"
title: A photodiode
inputs: {specimen: {ask: Serial number, unattended: PD-1}}
uses: {diode: photodiode}
main:
  - sweep:
      set: diode.lamp
      over: OVER
      steps: [{settle: {time: 1 s}}, {measure: {channels: [diode.signal]}}]
"""
DARK = HEAD.replace("id: ID", "id: DARK").replace("OVER", "[0 A]")
LIGHT = HEAD.replace("id: ID", "id: LIGHT").replace("OVER", "[1 A]")
STRANGER = f"""{LIGHT}analysis:
  - net_signal:
      of: diode.signal
      dark: {{procedure: DARK, max_age: 2 h, same: [station, mandrel]}}
acceptance:
  rule: simple
  limits: [{{of: net, max: 1.6 V, source: demonstration only}}]
"""
TARED = f"""{LIGHT.replace("[1 A]", "[1 A, 2 A]")}analysis:
  - readings:
      of: diode.signal
      per: diode.lamp
      tare: {{name: dark, procedure: DARK, max_age: 2 h}}
      result: {{name: net, unit: V}}
"""


@pytest.fixture
def lab(tmp_path):
    (tmp_path / "plugins").mkdir()
    (tmp_path / "plugins/net.py").write_text(PLUGIN, encoding="utf-8")
    files = {"station": STATION, "dark": DARK, "stranger": STRANGER, "tared": TARED}
    for name, text in files.items():
        (tmp_path / f"{name}.yaml").write_text(text, encoding="utf-8")
    (tmp_path / "runs").mkdir()
    return tmp_path


def call_on(lab, command, name, *more, station="station.yaml"):
    arguments = (command, lab / f"{name}.yaml", "--station", lab / station)
    return call(*arguments, "--runs", lab / "runs", *more)


def run_of(lab, name, *more, code=0):
    before = set((lab / "runs").iterdir())
    called = call_on(lab, "run", name, "--unattended", *more)
    assert called.code == code, called.err
    (folder,) = {*(lab / "runs").iterdir()} - before
    return folder


def result_of(folder):
    return json.loads((folder / "result.json").read_text(encoding="utf-8"))


def test_kit_tries_an_analysis_with_its_partner_run(lab):
    checked = call("check-plugin", "net_signal", "--drop-in", lab / "plugins")
    assert checked.code == 0, checked.out + checked.err
    assert "pass  refuses_a_partner_run_that_lacks_a_channel" in checked.out
    assert "pass  covers_the_truth" in checked.out
    text = PLUGIN.replace("if not found: raise DataError", "if not found and 0: raise DataError")
    (lab / "plugins/net.py").write_text(text, encoding="utf-8")
    assert call("check-plugin", "net_signal", "--drop-in", lab / "plugins").code == 1


@pytest.mark.parametrize("command", ["check", "plan"])
def test_missing_partner_run_is_reported_with_its_place(lab, command):
    called = call_on(lab, command, "stranger")
    assert called.code == 3
    (error,) = [line for line in called.err.splitlines() if "there is no dark run" in line]
    assert "stranger.yaml:15:7: error: analysis[0].net_signal.dark: there is no dark run" in error
    assert "station 'optics', mandrel 'M-1', begun within 2 h" in called.err
    assert call_on(lab, "run", "stranger", "--unattended").code == 5
    assert list((lab / "runs").iterdir()) == []


def test_impossible_requirement_of_a_partner_run_is_refused(lab):
    for old, new, message in (
        ("[station, mandrel]", "[station, mandril]", "a rig has no key 'mandril'"),
        ("procedure: DARK, ", "", "the key 'procedure' is missing"),
    ):
        (lab / "wrong.yaml").write_text(STRANGER.replace(old, new), encoding="utf-8")
        called = call_on(lab, "check", "wrong")
        assert called.code == 3
        assert message in called.err
        assert "wrong.yaml:15:" in called.err


def test_partner_run_with_another_mandrel_is_refused(lab):
    run_of(lab, "dark")
    other = STATION.replace("mandrel: M-1", "mandrel: M-2")
    (lab / "other.yaml").write_text(other, encoding="utf-8")
    called = call_on(lab, "check", "stranger", station="other.yaml")
    assert called.code == 3
    assert "its mandrel is 'M-1', but 'M-2' is needed" in called.err


def test_third_party_analysis_is_verified_with_its_partner_run(lab, tmp_path):
    dark = run_of(lab, "dark")
    checked = call_on(lab, "check", "stranger")
    assert checked.code == 0, checked.err
    assert f"Its dark run would be {dark.name}." in checked.out
    folder = run_of(lab, "stranger")
    result = result_of(folder)
    assert result["results"][0]["estimate"]["value"] == pytest.approx(1.5)
    assert result["partner_runs"]["dark"]["id"] == dark.name
    assert result["partner_runs"]["dark"]["digest_sha256"] == read(dark).digest
    assert read(folder).partners["dark"].digest == read(dark).digest
    page = (folder / "report.html").read_text(encoding="utf-8")
    assert dark.name in page
    assert read(dark).digest in page
    station = ("--station", lab / "station.yaml")
    reanalysed = call("analyse", folder, *station, "--json")
    assert json.loads(reanalysed.out)["results"] == result["results"]
    letterhead = make_letterhead(tmp_path / "letterhead")
    issued = call(
        "certify", folder, "--letterhead", letterhead, "--authorised-by", "A. Nother",
        "--customer", "C", "--customer-contact", "D", "--item", "Diode", "--item-id", "1",
        "--item-condition", "new", "--received", "2020-01-01", "--operator", "O",
        "--not-for-certification", "--out", tmp_path / "out", *station,
    )  # fmt: skip
    assert issued.code == 0, issued.err
    (content,) = (tmp_path / "out").glob("*.json")
    evidence = json.loads(content.read_text(encoding="utf-8"))["evidence"]
    assert evidence["partner_runs"]["dark"]["digest_sha256"] == read(dark).digest
    verified = call("verify", content, "--letterhead", letterhead, "--runs", lab / "runs", *station)
    assert verified.code == 0, verified.out + verified.err


def test_another_partner_run_can_be_named(lab):
    first = run_of(lab, "dark")
    second = run_of(lab, "dark")
    folder = run_of(lab, "stranger", "--partner", f"dark={first.name}")
    assert result_of(folder)["partner_runs"]["dark"]["id"] == first.name != second.name
    named = ("--partner", f"dark={second.name}", "--runs", lab / "runs", "--json")
    reanalysed = call("analyse", folder, "--station", lab / "station.yaml", *named)
    assert json.loads(reanalysed.out)["partner_runs"]["dark"]["id"] == second.name
    refused = call_on(lab, "run", "stranger", "--unattended", "--partner", f"light={first.name}")
    assert refused.code == 2
    assert "asks for no partner run 'light'" in refused.err


def test_tare_needs_no_python(lab):
    assert "there is no dark run" in call_on(lab, "check", "tared").err
    run_of(lab, "dark")
    results = result_of(run_of(lab, "tared"))["results"]
    assert [result["estimate"]["value"] for result in results] == pytest.approx([1.5, 3.0])
    # the offset of one meter cancels: nothing else is known about it
    assert [result["estimate"]["standard_uncertainty"] for result in results] == [
        pytest.approx(0.0, abs=1e-9)
    ] * 2
    other = STATION.replace("accuracy: {offset: 5 mV}", "accuracy: 5 mV")
    (lab / "station.yaml").write_text(other, encoding="utf-8")
    results = result_of(run_of(lab, "tared"))["results"]
    u = sqrt(2) * 0.005 / sqrt(3)
    assert results[0]["estimate"]["standard_uncertainty"] == pytest.approx(u, rel=1e-6)


def test_tare_of_several_places_is_averaged_only_on_request(lab):
    """The mean of a through connection at nine frequencies was subtracted at each of them."""
    dark, tared = (lab / f"{name}.yaml" for name in ("dark", "tared"))
    dark.write_text(DARK.replace("[0 A]", "[1 A, 2 A]"), encoding="utf-8")
    run_of(lab, "dark")
    refused = call_on(lab, "check", "tared")
    assert refused.code == 3
    assert "analysis[0].readings.tare: there is no dark run" in refused.err
    assert "it has 2 values of diode.lamp: write 'per: diode.lamp'" in refused.err
    for per, differences in (("diode.lamp", [0.0, 0.0]), ("[]", [-0.75, 0.75])):
        tared.write_text(TARED.replace("{name: dark", f"{{per: {per}, name: dark"), "utf-8")
        results = result_of(run_of(lab, "tared"))["results"]
        assert [result["estimate"]["value"] for result in results] == pytest.approx(differences)
