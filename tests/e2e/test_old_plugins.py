"""Plugins that `rigrunner new` of version 0.1.0 created run unmodified, and pass their tests."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

OLD = Path(__file__).parents[1] / "data" / "0.1.0" / "plugins"
KINDS = sorted(each.name for each in OLD.iterdir())
NEW_SINCE = {"compensation": ["transducer_errors_are_in_the_budget"]}
"""Newer checks of the kit, which these plugins do not pass."""
pytestmark = pytest.mark.thorough


def test_every_kind_of_version_0_1_0_is_present():
    assert KINDS == ["compensation", "device", "fit", "importer", "outlier-rule", "report"]


def install(kind, folder):
    """Copy a package, with the files that its installation would write; return its folder."""
    package = folder / kind
    shutil.copytree(OLD / kind, package)
    (module,) = (each.name for each in (package / "src").iterdir())
    info = package / "src" / f"{module}-0.1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {module}\nVersion: 0.1.0\n")
    (info / "entry_points.txt").write_text(f"[rigrunner]\n{module} = {module}\n")
    return package


def run_module(package, *words):
    """Run a Python module with the plugin on its path; deprecated names only warn."""
    environment = {name: value for name, value in os.environ.items() if name != "PYTEST_ADDOPTS"}
    environment["PYTHONPATH"] = os.pathsep.join(["src", *filter(None, sys.path)])
    return subprocess.run(
        [sys.executable, "-m", *words], cwd=package, env=environment,
        capture_output=True, text=True, check=False,
    )  # fmt: skip


@pytest.mark.parametrize("kind", KINDS)
def test_old_plugin_passes_its_own_tests(kind, tmp_path):
    package = install(kind, tmp_path)
    done = run_module(
        package, "pytest", "-q", "-p", "no:cacheprovider", "-W", "default::DeprecationWarning"
    )
    failed = re.findall(r"^FAILED \S+\[(\w+)\]", done.stdout, re.MULTILINE)
    assert failed == NEW_SINCE.get(kind, []), done.stdout + done.stderr
    assert int(re.search(r"(\d+) passed", done.stdout)[1]) > len(failed)
    assert "DeprecationWarning: import rigrunner_testing instead" in done.stdout


def test_old_device_runs_its_upgraded_procedure(tmp_path):
    package = install("device", tmp_path)
    assert run_module(package, "rigrunner", "upgrade", "example/procedure.yaml").returncode == 0
    words = ("run", "example/procedure.yaml", "--station", "example/station.yaml", "--unattended")
    done = run_module(package, "rigrunner", *words, "--runs", str(tmp_path / "runs"))
    assert done.returncode == 0, done.stdout + done.stderr
    assert list((tmp_path / "runs").glob("*/run.h5"))
