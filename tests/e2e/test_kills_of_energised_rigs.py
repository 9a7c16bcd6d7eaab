"""kill -9 with an energised rig: no row is lost; the rig is safe, or the next start reports it.

A longer form: RIGRUNNER_KILLS=300 pytest -s tests/e2e/test_kills_of_energised_rigs.py, or the
helper; see docs/explanation/safety.md.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys

import pytest

from helpers_docs import ROOT

pytestmark = [
    pytest.mark.skipif(not hasattr(os, "fork"), reason="kill -9 needs a Unix"),
    pytest.mark.in_real_time,
]
KILLS = int(os.environ.get("RIGRUNNER_KILLS", "5"))
SEED = 20261122


@pytest.mark.thorough
def test_no_kill_leaves_an_unreported_energised_rig(tmp_path):
    from e2e import helpers_rig_kills  # noqa: PLC0415  (of Unix alone)

    program = [sys.executable, "-m", "e2e.helpers_rig_kills", tmp_path, str(KILLS), str(SEED)]
    done = subprocess.run(program, cwd=ROOT / "tests", capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    kills = [json.loads(line) for line in done.stdout.splitlines() if line.startswith("{")]
    print(helpers_rig_kills.table(kills))  # noqa: T201  (the table, for pytest -s)
    assert len(kills) == KILLS
    assert len({kill["kind"] for kill in kills}) > 1
