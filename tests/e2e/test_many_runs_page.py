"""The page on many runs: its program works unchanged, and its file is an analysis."""

from __future__ import annotations

import subprocess
import sys

import pytest

from helpers_docs import ROOT, code_blocks
from rigrunner.api.errors import InvalidFileError
from rigrunner.procedure import AnalysisFile
from rigrunner.registry import load_registry
from rigrunner.yamlfile import parse, validate
from rigrunner_fleet.reanalysis.changes import check_settings

BLOCKS = code_blocks(ROOT / "docs/how-to/analyse-many-runs.md")


def test_program_processes_each_item_once(tmp_path):
    (code,) = (block.code for block in BLOCKS if block.language == "python")
    (tmp_path / "program.py").write_text(code)
    done = subprocess.run(
        [sys.executable, "program.py"], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    assert sorted(line.split() for line in done.stdout.splitlines()) == [
        ["1", "2"],
        ["2", "4"],
        ["3", "6"],
    ]


def test_file_is_an_analysis():
    by_energy, largest = (block.code for block in BLOCKS if block.language == "yaml")
    document = parse(by_energy, "energy.yaml")
    assert validate(AnalysisFile, document).analysis["primary"] == "energy"
    check_settings(document, load_registry())
    with pytest.raises(InvalidFileError, match=r"analysis\.primari: unknown key 'primari'"):
        check_settings(parse(by_energy.replace("primary", "primari"), "e.yaml"), load_registry())
    (named,) = validate(AnalysisFile, parse(largest, "largest.yaml")).named
    assert named.name == "readings"
