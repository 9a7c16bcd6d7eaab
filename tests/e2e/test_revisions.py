"""A laboratory's own rules have a new revision: `verify` on documents of the one before.

Two versions of one distribution with a plugin, each in its own folder as pip would install it;
each program is a process that finds one of them, or neither.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest

from helpers_cli import Called

pytestmark = pytest.mark.thorough

TESTS = Path(__file__).parents[1]
RULE = '''
from rigrunner.api.analysis import Rejection
from rigrunner.api.hooks import DecisionRuleRecord, OutlierRuleRecord, hookimpl
from rigrunner.api.verdict import Verdict, Zone

api_version = 1


class AsAgreed:
    """Version 1 wants a distance of 0.01 N·m, version 2 one of 0.02 N·m."""

    words = {"en": "as agreed with the customer", "de": "wie mit dem Kunden vereinbart"}

    def __call__(self, limits, estimate):
        return [Zone(Verdict.PASS, 0.01 * {revision}, "w")]


@hookimpl
def rigrunner_decision_rules():
    return [
        DecisionRuleRecord(
            name="lab_limit",
            help="Passes what is within the limit by what was agreed.",
            factory=lambda _: AsAgreed(),
            revision={revision},
        )
    ]


def keep_all_but_the_largest(values):
    """Version 1 leaves out one value, version 2 two of them."""
    largest = sorted(range(len(values)), key=lambda index: -values[index])[:{revision}]
    return [Rejection(index, float(values[index]), "lab_rule", 1.0, 0.5) for index in largest]


@hookimpl
def rigrunner_outlier_rules():
    return [
        OutlierRuleRecord(
            name="lab_rule",
            help="Leaves out the largest values.",
            factory=lambda _: keep_all_but_the_largest,
            revision={revision},
        )
    ]
'''
MAKE = """
import sys
from pathlib import Path
from e2e.helpers_tamper import issue, letterhead
from helpers_workflow import quick_procedure, run

folder = Path(sys.argv[1])
change = ("outliers: {grubbs: {alpha: 0.05}}", "outliers: lab_rule")
limit = ("rule: guard_band_u", "rule: lab_limit")
for name, changes in {
    "no_load_inertia_sweep": [change], "starting_torque_1000n": [change, limit]
}.items():
    finished = run(quick_procedure(folder, name, *changes), folder / "runs")
    assert finished.error is None, finished.error
issue(finished.folder, letterhead(folder / "lab"), folder / "out")
print(finished.folder)
"""


def install_plugin(folder, revision):
    """Install a version of the laboratory's plugin into a folder, as pip does."""
    info = folder / f"labmethods-{revision}.0.dist-info"
    info.mkdir(parents=True)
    text = f"Metadata-Version: 2.1\nName: labmethods\nVersion: {revision}.0\n"
    (info / "METADATA").write_text(text, "utf-8")
    (info / "entry_points.txt").write_text("[rigrunner]\nlabmethods = labmethods\n", "utf-8")
    (folder / "labmethods.py").write_text(RULE.replace("{revision}", str(revision)), "utf-8")
    return folder


@dataclass(frozen=True)
class Laboratory:
    """A run and its certificate by version 1 of the rule, and how to call the program."""

    folder: Path

    def python(self, version, *words):
        """Call Python with that version of the plugin installed; None for none."""
        path = [TESTS, *([] if version is None else [self.folder / f"version-{version}"])]
        done = subprocess.run(
            [sys.executable, *map(str, words)],
            env=os.environ | {"PYTHONPATH": os.pathsep.join(map(str, path))},
            capture_output=True,
            text=True,
            check=False,
        )
        return Called(done.returncode, done.stdout, done.stderr)

    def verify(self, version, *words):
        return self.python(version, "-m", "rigrunner", "verify", *words)

    @property
    def certificate(self):
        (content,) = (self.folder / "out").glob("*.json")
        return (content, "--runs", self.folder / "runs", "--letterhead", self.letterhead)

    @property
    def letterhead(self):
        return self.folder / "lab" / "letterhead"

    @property
    def run(self):
        (run_folder,) = (self.folder / "runs").glob("*SSPB-STT*")
        return run_folder


@pytest.fixture(scope="module")
def laboratory(tmp_path_factory):
    folder = tmp_path_factory.mktemp("laboratory")
    for revision in (1, 2):
        install_plugin(folder / f"version-{revision}", revision)
    laboratory = Laboratory(folder)
    done = laboratory.python(1, "-c", MAKE, folder)
    assert done.code == 0, done.err
    return laboratory


def test_original_revision_matches(laboratory):
    for words in (laboratory.certificate, [laboratory.run]):
        done = laboratory.verify(1, *words)
        assert (done.code, done.out.splitlines()[0]) == (0, "MATCH"), done


@pytest.mark.parametrize(
    ("version", "said"),
    [
        (2, "installed 2; version 1.0 of labmethods recomputes them"),
        (None, "not installed; what was installed then (labmethods 1.0, "),
    ],
)
def test_another_revision_does_not_recompute_numbers(laboratory, version, said):
    for words in (laboratory.certificate, [laboratory.run]):
        done = laboratory.verify(version, *words)
        first_line = f"NUMBERS NOT RECOMPUTED: decision rule 'lab_limit' revision 1, {said}"
        assert (done.code, done.out.startswith(first_line)) == (13, True), done
        assert f"outlier rule 'lab_rule' revision 1, {said}" in done.out
        assert "OK       manifest of the run file" in done.out
    (_, *words) = laboratory.certificate
    done = laboratory.verify(version, laboratory.certificate[0], *words)
    for item in (
        "seal of",
        "record of",
        "bytes of run.h5",
        ".html regenerated from its content",
    ):
        assert f"{item}" in done.out, done.out


def test_changed_certificate_is_found_by_another_revision(laboratory, tmp_path):
    certificate = laboratory.certificate[0]
    changed = tmp_path / certificate.name
    changed.write_bytes(certificate.read_bytes().replace(b"Bearing", b"Wearing", 1))
    done = laboratory.verify(2, changed, *laboratory.certificate[1:])
    assert done.code == 1
    assert done.out.startswith("DOES NOT MATCH: 2 differences; NUMBERS NOT RECOMPUTED: "), done.out


def test_numbers_of_another_revision_differ(laboratory):
    """Otherwise the revision would be of no use: one run gives two results."""
    results = {
        version: laboratory.python(version, "-m", "rigrunner", "analyse", laboratory.run).out
        for version in (1, 2)
    }
    assert results[1] != results[2]


def test_decision_rule_of_the_laboratory_is_in_result_and_certificate(laboratory):
    result = json.loads((laboratory.run / "result.json").read_text("utf-8"))
    (document,) = (laboratory.folder / "out").glob("*.json")
    certificate = json.loads(document.read_text("utf-8"))
    rule = "lab_limit: as agreed with the customer"
    assert result["decision"]["rule"] == rule
    assert result["decision"]["guard_band"] == {"value": 0.01, "unit": "N·m"}
    assert result["revisions"]["decision_rule lab_limit"] == 1
    assert certificate["conformity"]["rule"] == "lab_limit"
    assert certificate["conformity"]["rule_words_in"] == {"de": "wie mit dem Kunden vereinbart"}
    assert certificate["evidence"]["revisions"]["decision_rule lab_limit"] == 1
    assert rule in (laboratory.run / "report.html").read_text("utf-8")
    page = document.with_suffix(".html").read_text("utf-8")
    assert "as agreed with the customer" in page
