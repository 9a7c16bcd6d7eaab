"""The mutation tool on a toy project."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from mutation.mutants import mutants_of, sample

REPOSITORY = Path(__file__).resolve().parents[3]
TOY = '''\
"""A valve that opens by pressure."""

OPENS_AT_BAR = 3.0

def is_open(bar: float) -> bool:
    return bar >= OPENS_AT_BAR


def turns(bar: float) -> int:
    count = 0
    while count < bar:
        count += 1
    return count


def never_called() -> int:
    return 7
'''
VERDICT = re.compile(r"^\d+ src/toy.py:\d+ [a-z/ ]+: (.*)\n    (.*)$", re.MULTILINE)
TESTS = """\
import toy


def test_it_opens():
    assert toy.is_open(4.0)
    assert not toy.is_open(2.0)


def test_it_turns():
    assert toy.turns(2) == 2
"""


@pytest.fixture
def project(tmp_path):
    (tmp_path / "src").mkdir()
    (tmp_path / "src" / "toy.py").write_text(TOY, encoding="utf-8")
    (tmp_path / "test_toy.py").write_text(TESTS, encoding="utf-8")
    return tmp_path


def run_tool(project, *options):
    command = [sys.executable, "-m", "tests.mutation", "--root", project, "--packages", "src"]
    command += ["--sources", "src/toy.py", "--tests", "test_toy.py", "--more", "1", "--verbose"]
    command += ["--equivalent", project / "equivalent.toml", *options]
    process = subprocess.run(command, cwd=REPOSITORY, capture_output=True, text=True, check=False)
    return process.returncode, process.stdout + process.stderr


@pytest.mark.thorough
@pytest.mark.skipif(not hasattr(os, "fork"), reason="the tool forks")
def test_surviving_mutants_are_listed_and_sources_unchanged(project):
    equivalent = """
[[mutant]]
file = "src/toy.py"
change = "turns: count < bar -> count != bar"
why = "not among these"

[[mutant]]
file = "src/toy.py"
change = "never_called: 7 -> 8"
why = "nobody calls it"
"""
    (project / "equivalent.toml").write_text(equivalent, encoding="utf-8")
    code, output = run_tool(project, "--only", *["1", "2", "3", "4", "8", "12", "13"])
    outcomes = {name: outcome for outcome, name in VERDICT.findall(output)}
    assert outcomes == {
        "is_open: bar >= OPENS_AT_BAR -> bar > OPENS_AT_BAR": "survived (1 tests)",
        "is_open: bar >= OPENS_AT_BAR -> bar < OPENS_AT_BAR": "killed (test_toy.py::test_it_opens)",
        "module: 3.0 -> 300.0": "killed (test_toy.py::test_it_opens)",
        "is_open: return bar >= OPENS_AT_BAR -> return None": "killed (test_toy.py::test_it_opens)",
        "turns: count += 1 -> pass": "hung (test_toy.py::test_it_turns)",
        "never_called: 7 -> 8": "equivalent: nobody calls it",
        "never_called: return 7 -> return None": "no test runs it (0 tests)",
    }
    assert "score 66.7%: 4 of 6 noticed, 2 not" in output
    assert code == 1
    assert (project / "src" / "toy.py").read_text(encoding="utf-8") == TOY
    assert sorted(path.name for path in project.iterdir()) == [
        "equivalent.toml", "src", "test_toy.py"
    ]  # fmt: skip


def test_seed_determines_the_sample_of_mutants(project):
    source = project / "src" / "toy.py"
    chosen = [sample(project, [source], 5, seed) for seed in (18, 18, 19)]
    assert chosen[0] == chosen[1] != chosen[2]
    assert len(set(chosen[0])) == 5


def test_every_listed_equivalent_mutant_exists():
    text = (REPOSITORY / "tests/mutation/equivalent.toml").read_text(encoding="utf-8")
    for entry in tomllib.loads(text)["mutant"]:
        mutants = mutants_of(REPOSITORY, REPOSITORY / entry["file"])
        assert entry["change"] in {mutant.change for mutant in mutants}, entry


def test_code_without_effect_is_not_mutated(project):
    source = project / "src" / "toy.py"
    source.write_text(
        '"""Text."""\n'
        "from typing import TYPE_CHECKING, Annotated\n"
        "if TYPE_CHECKING:\n    LEAST = 1\n"
        '__all__ = ["f"]\n'
        'text: Annotated[str, 5] = f"{1 + 1} of" + " 2"\n',
        encoding="utf-8",
    )
    assert mutants_of(project, source) == []


@pytest.mark.thorough
@pytest.mark.skipif(not hasattr(os, "fork"), reason="the tool forks")
def test_every_user_of_a_shared_fixture_is_charged_its_time(project):
    """Any of them may run first with a mutant, and must not count as hanging."""
    shared = """
import time
import pytest
import toy


@pytest.fixture(scope="module")
def slow():
    time.sleep(0.3)


def test_first(slow):
    assert toy.is_open(4.0)


def test_second(slow):
    assert not toy.is_open(2.0)


def test_alone():
    assert toy.is_open(3.0)
"""
    (project / "test_toy.py").write_text(shared, encoding="utf-8")
    run_tool(project, "--mutants", "1", "--keep", project / "kept.json")
    record = json.loads((project / "kept.json").read_text(encoding="utf-8"))
    seconds = {name.partition("::")[2]: test_seconds for name, test_seconds, _ in record["tests"]}
    assert min(seconds["test_first"], seconds["test_second"]) >= 0.3
    assert set(seconds) == {"test_first", "test_second", "test_alone"}
