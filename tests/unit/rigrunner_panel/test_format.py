"""Numbers on the screen, by its own code."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from pathlib import Path

import pytest

import rigrunner_panel

FORMAT = Path(rigrunner_panel.__file__).parent / "static/js/format.js"


@pytest.mark.skipif(
    shutil.which("node") is None and os.environ.get("RIGRUNNER_REQUIRE_BROWSER") != "1",
    reason="there is no Node.js",
)
def test_a_set_value_is_shown_as_a_person_wrote_it(tmp_path):
    shutil.copy(FORMAT, tmp_path / "format.mjs")
    program = """
      import { plain } from './format.mjs';
      const values = [16.5, 35, 0.25, 0, -2.5, 1000, 1 / 3, null, NaN];
      console.log(JSON.stringify(values.map(plain)));
    """
    done = subprocess.run(
        ["node", "--input-type=module", "-e", program],
        cwd=tmp_path, capture_output=True, text=True, check=True, timeout=60,
    )  # fmt: skip
    assert json.loads(done.stdout) == [
        *("16.5", "35", "0.25", "0", "\N{MINUS SIGN}2.5", "1000", "0.333333"),
        *("\N{EN DASH}", "\N{EN DASH}"),
    ]
