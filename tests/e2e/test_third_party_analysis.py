"""A third-party analysis in under 40 lines: kit, check, run, live, report, certificate."""

from __future__ import annotations

import json
import re

import pytest

from helpers_certificate import make_letterhead
from helpers_cli import call
from rigrunner.run.locate import find_station
from rigrunner.runfile import read

pytestmark = pytest.mark.usefixtures("without_pdf")

PLUGIN = '''\
import numpy as np
from rigrunner.api.analysis import Component, NeededChannel, Requirements
from rigrunner.api.data import Estimate
from rigrunner.api.errors import DataError
from rigrunner.api.findings import Findings, MeasurementResult, ResultDefinition
from rigrunner.api.hooks import AnalysisRecord, hookimpl
from rigrunner.api.member import Member
from rigrunner.api.settings import Settings
from rigrunner.signal.uncertainty import combine

api_version = 1
WARMING = ResultDefinition(name="warming", text="warming of the bearing", unit="K")

class WarmingSettings(Settings):
    of: Member
    """The temperature."""

class Warming:
    def __init__(self, told):
        self.of, self.ends, self.count = told.of, [], 0
    def __call__(self, run):
        found = [np.asarray(e.channels[self.of]) for e in run.recordings if self.of in e.channels]
        if not found: raise DataError(f"{self.of} was not recorded")
        values = np.concatenate(found)
        errors = run.reading_errors(self.of, values.max())
        lines = tuple(Component(e.name, 2**0.5 * e.u, e.dof, e.distribution, True) for e in errors)
        return shown(values, combine(lines), len(values), lines)
    def begin(self, recording, run): pass
    def take(self, block):
        values = np.append(self.ends, block.channels[self.of])
        self.ends, self.count = [values.min(), values.max()], self.count + block.samples
    def findings(self): return shown(self.ends, (np.nan, np.nan), self.count, ())

def shown(values, u_and_dof, count, lines):
    return Findings(results=(MeasurementResult(of=WARMING, components=lines, readings=count,
        estimate=Estimate(float(np.ptp(values)), *u_and_dof, "K")),))

@hookimpl
def rigrunner_analyses(): return [AnalysisRecord(
    name="warming", help="How much a recorded temperature rose", settings=WarmingSettings,
    factory=Warming, live=Warming, yields=lambda _: (WARMING,),
    requires=lambda told: Requirements(rate_hz=10, cycles=3, channels=(NeededChannel(
        name=told.of, key=("of",), enters=("warming",), quantity="temperature"),)),
    trial={"of": "tester.temperature"}, trial_units={"tester.temperature": "K"})]
'''
PROCEDURE = """\
rigrunner: procedure/2
id: WARM
revision: "A"
title: Warming of a bearing
inputs: {specimen: {ask: Serial number, unattended: DEMO-1}}
uses: {tester: swing_tester}
setup:
  - set: {tester.load: 1000 N}
  - set: {tester.frequency: 10 Hz}
main:
  - repeat:
      times: 3
      steps:
        - record: {channels: [tester.angle, tester.torque, tester.temperature], duration: 10 s}
teardown:
  - set: {tester.frequency: 0 Hz}
  - set: {tester.load: 0 N}
analysis:
  - warming: {of: tester.temperature}
acceptance:
  rule: simple
  limits: [{of: warming, max: 5 K, source: demonstration only}]
"""


@pytest.fixture(scope="module")
def lab(tmp_path_factory):
    folder = tmp_path_factory.mktemp("lab")
    (folder / "plugins").mkdir()
    (folder / "plugins/warming.py").write_text(PLUGIN, encoding="utf-8")
    station = find_station("simulated_wear").read_text(encoding="utf-8")
    station = station.replace("id: simulated_wear\n", "id: simulated_wear\nplugins: plugins\n")
    (folder / "station.yaml").write_text(station, encoding="utf-8")
    (folder / "warm.yaml").write_text(PROCEDURE, encoding="utf-8")
    return folder


@pytest.fixture(scope="module")
def ran(lab):
    called = call(
        "run", lab / "warm.yaml", "--station", lab / "station.yaml", "--unattended", "--runs",
        lab / "runs",
    )  # fmt: skip
    assert called.code == 0, called.err
    (folder,) = (lab / "runs").iterdir()
    return called, folder, json.loads((folder / "result.json").read_text(encoding="utf-8"))


def test_analysis_has_fewer_than_forty_lines_and_passes_the_kit(lab):
    assert len([line for line in PLUGIN.splitlines() if line.strip()]) < 40
    checked = call("check-plugin", "warming", "--drop-in", lab / "plugins")
    assert checked.code == 0, checked.out + checked.err
    assert "pass  live_shows_what_it_finds" in checked.out
    assert "pass  covers_the_truth" in checked.out


@pytest.mark.parametrize(
    ("old", "new", "line", "message"),
    [
        ("of: tester.temperature}", "of: tester.torque}", 19, "tester.torque is a torque"),
        ("duration: 10 s", "duration: 0.2 s", 14, "needs at least 4 cycles in each recording"),
        (
            "record: {channels: [tester.angle, tester.torque, tester.temperature], duration: 10 s}",
            "measure: {channels: [tester.temperature]}",
            19,
            "needs a recording, but only single values are measured",
        ),
    ],
)
def test_unmet_requirement_is_refused_before_anything_moves(  # noqa: PLR0917  (a case)
    lab, tmp_path, old, new, line, message
):
    assert old in PROCEDURE
    (tmp_path / "wrong.yaml").write_text(PROCEDURE.replace(old, new), encoding="utf-8")
    called = call("check", tmp_path / "wrong.yaml", "--station", lab / "station.yaml")
    assert called.code == 3
    (error,) = [stderr_line for stderr_line in called.err.splitlines() if message in stderr_line]
    assert f"wrong.yaml:{line}:" in error


def test_analysis_runs_with_live_value_verdict_and_report(ran):
    called, folder, document = ran
    (result,) = document["results"]
    samples = [recording.channels["tester.temperature"] for recording in read(folder).recordings]
    rise = max(sample[:].max() for sample in samples) - min(sample[:].min() for sample in samples)
    assert result["estimate"]["value"] == pytest.approx(rise, rel=1e-9)
    shown = re.findall(r"so far: warming of the bearing: (\S+) K of (\d+) readings", called.err)
    assert [int(count) for _, count in shown] == [
        sum(map(len, samples[:index])) for index in (1, 2, 3)
    ]
    assert float(shown[-1][0]) == pytest.approx(rise, rel=1e-4)
    assert document["verdict"]["verdict"] == "pass"
    assert "warming of the bearing" in (folder / "report.html").read_text(encoding="utf-8")


def test_result_is_certified_verified_and_archived(ran, lab, tmp_path):
    folder = ran[1]
    letterhead = make_letterhead(tmp_path / "letterhead")
    issued = call(
        "certify", folder, "--letterhead", letterhead, "--authorised-by", "A. Nother",
        "--customer", "C", "--customer-contact", "D", "--item", "Bearing", "--item-id", "1",
        "--item-condition", "new", "--received", "2020-01-01", "--operator", "O",
        "--not-for-certification", "--out", tmp_path / "out",
        "--station", lab / "station.yaml",
    )  # fmt: skip
    assert issued.code == 0, issued.err
    (content,) = (tmp_path / "out").glob("*.json")
    (named,) = json.loads(content.read_text(encoding="utf-8"))["named"]
    assert named["name"] == "warming"
    verified = call(
        "verify", content, "--letterhead", letterhead, "--runs", folder.parent, "--station",
        lab / "station.yaml",
    )  # fmt: skip
    assert verified.code == 0, verified.out + verified.err
    database = tmp_path / "archive.db"
    indexed = call("archive", "index", folder.parent, "--database", database)
    assert indexed.code == 0, indexed.err
    searched = call("archive", "search", "--database", database, "--result", "warming")
    assert folder.name in searched.out, searched.err
