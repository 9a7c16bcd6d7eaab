"""A third-party analysis adds its own section to a report: words, equation, figure, table."""

from __future__ import annotations

import base64
import json
import re

import pytest

from helpers_any_quantity import written
from helpers_cli import call

PLUGIN = '''\
"""The internal resistance of a supply, with a section of its own in the report."""

import numpy as np
from rigrunner.api.data import Estimate
from rigrunner.api.figures import Axis, Figure, Series
from rigrunner.api.findings import (
    Findings, Formula, MeasurementResult, ReportSection, ResultDefinition, Table,
)
from rigrunner.api.hooks import AnalysisRecord, NoSettings, hookimpl

api_version = 1
RESISTANCE = ResultDefinition(name="resistance", unit="Ω")


def analysis(settings):
    def analyse(run):
        rows = run.measurements
        pairs = [(r.setpoints["bench.current"], r.values["bench.voltage"]) for r in rows]
        current, voltage = np.array(pairs).T
        slope, intercept = np.polyfit(current, voltage, 1)
        estimate = Estimate(-float(slope), 0.001, 5.0, "Ω")
        drop = Series.over(current, voltage - intercept, "drop", "joined")
        section = ReportSection(
            title="Internal resistance",
            paragraphs=("The voltage falls with the current <as it should>.",),
            formulas=(Formula(symbol="R_i", text="(U_0 - U) / I"),),
            figures=(Figure("Drop", Axis("I", "A"), Axis("drop", "V"), (drop,)),),
            tables=(Table(title="Pairs", columns=("I / A", "U / V"), rows=tuple(pairs)),),
        )
        found = MeasurementResult(of=RESISTANCE, estimate=estimate)
        return Findings(results=(found,), sections=(section,))
    return analyse


@hookimpl
def rigrunner_analyses():
    return [AnalysisRecord(name="internal", help="Internal resistance", settings=NoSettings,
                           factory=analysis, yields=lambda _: (RESISTANCE,))]
'''
PROCEDURE = """\
rigrunner: procedure/2
id: PSU-RI
revision: "A"
title: Internal resistance of a power supply
inputs: {specimen: {ask: Serial number, unattended: PSU-1}}
uses: {bench: supply_bench}
main:
  - sweep:
      set: bench.current
      over: [1 A, 2 A, 5 A]
      steps: [{measure: {channels: [bench.voltage]}}]
analysis: [{internal: {}}]
"""


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("lab")
    (folder / "plugins").mkdir()
    (folder / "plugins" / "internal.py").write_text(PLUGIN, encoding="utf-8")
    procedure, station = written(folder, procedure=PROCEDURE)
    text = station.read_text(encoding="utf-8")
    station.write_text(text.replace("\nid: ", "\nplugins: plugins\nid: ", 1), encoding="utf-8")
    words = ["--station", station, "--unattended", "--runs", folder / "runs"]
    called = call("run", procedure, *words)
    assert called.code == 0, called.err
    (run_folder,) = (folder / "runs").iterdir()
    return run_folder


def test_analysis_has_fewer_than_forty_lines():
    code = [line for line in PLUGIN.splitlines() if line.strip()]
    assert len(code) < 40


def test_report_has_the_section_after_the_results(run):
    text = (run / "report.html").read_text(encoding="utf-8")
    listed = re.findall(r'<li><a href="#([a-z0-9-]+)">([^<]*)', text)
    names = [name for name, _ in listed]
    assert ("given-1", "Internal resistance") in listed
    assert names.index("given-1") == names.index("results") + 1
    section = text.split('<section id="given-1">')[1].split("</section>")[0]
    assert "The voltage falls with the current &lt;as it should&gt;." in section
    assert 'alttext="R_i = (U_0 - U) / I"' in section
    assert "<mfrac>" in section
    (drawing,) = re.findall(r'src="data:image/svg\+xml;base64,([^"]*)"', section)
    assert base64.b64decode(drawing).lstrip().startswith((b"<?xml", b"<svg"))
    assert "drop / V from" in section
    assert section.count("<tr>") == 1 + 3
    assert '<th scope="col">I / A</th>' in section


def test_result_document_has_the_same_data(run):
    document = json.loads((run / "result.json").read_text(encoding="utf-8"))
    (section,) = document["sections"]
    assert section["title"] == "Internal resistance"
    assert len(section["tables"][0]["rows"]) == 3
    assert [point["x"] for point in section["figures"][0]["series"][0]["points"]] == [
        row[0] for row in section["tables"][0]["rows"]
    ]
