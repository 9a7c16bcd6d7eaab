"""kill -9 at random instants of a run, its sealing and its resumption: no run is lost or differs.

A longer form: RIGRUNNER_KILLS=300 pytest -s tests/e2e/test_kill_resume.py, or the helper; see
docs/reference/durability.md.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys

import pytest

from e2e import helpers_kill_resume
from helpers_docs import ROOT

KILLS = int(os.environ.get("RIGRUNNER_KILLS", "6"))
SEED = 20260301

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="kill -9 needs a Unix")


@pytest.mark.thorough
def test_every_killed_run_resumes_to_the_same_numbers(tmp_path):
    program = [sys.executable, "-m", "e2e.helpers_kill_resume", tmp_path, str(KILLS), str(SEED)]
    one_thread = os.environ | {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    done = subprocess.run(
        program,
        cwd=ROOT / "tests",
        capture_output=True,
        text=True,
        check=False,
        env=one_thread,
    )
    assert done.returncode == 0, done.stderr
    kills = [json.loads(line) for line in done.stdout.splitlines()]
    print("\n".join(helpers_kill_resume.table(kills)))  # noqa: T201  (the table, for pytest -s)
    assert len(kills) >= KILLS
    assert {kill["what"] for kill in kills} <= {"run", "resume"}
