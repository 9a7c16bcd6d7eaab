"""Plugins that `rigrunner new` of version 0.1.0 made run unmodified, and keep their own tests."""

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
"""Checks of the kit that came later, and that these plugins do not pass."""
pytestmark = pytest.mark.thorough


def test_every_kind_of_that_version_is_here():
    assert KINDS == ["compensation", "device", "fit", "importer", "outlier-rule", "report"]


def installed(kind, folder):
    """Copy a package, with what its installation would write; return its folder."""
    package = folder / kind
    shutil.copytree(OLD / kind, package)
    (module,) = (each.name for each in (package / "src").iterdir())
    info = package / "src" / f"{module}-0.1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {module}\nVersion: 0.1.0\n")
    (info / "entry_points.txt").write_text(f"[rigrunner]\n{module} = {module}\n")
    return package


def called(package, *words):
    """Run a module of Python beside the plugin; deprecated names are said, and are no errors."""
    environment = {name: each for name, each in os.environ.items() if name != "PYTEST_ADDOPTS"}
    environment["PYTHONPATH"] = os.pathsep.join(["src", *filter(None, sys.path)])
    return subprocess.run(
        [sys.executable, "-m", *words], cwd=package, env=environment,
        capture_output=True, text=True, check=False,
    )  # fmt: skip


@pytest.mark.parametrize("kind", KINDS)
def test_its_own_tests_pass(kind, tmp_path):
    package = installed(kind, tmp_path)
    done = called(
        package, "pytest", "-q", "-p", "no:cacheprovider", "-W", "default::DeprecationWarning"
    )
    failed = re.findall(r"^FAILED \S+\[(\w+)\]", done.stdout, re.MULTILINE)
    assert failed == NEW_SINCE.get(kind, []), done.stdout + done.stderr
    assert int(re.search(r"(\d+) passed", done.stdout)[1]) > len(failed)
    assert "DeprecationWarning: import rigrunner_testing instead" in done.stdout


def test_its_device_runs_its_procedure_once_that_is_upgraded(tmp_path):
    package = installed("device", tmp_path)
    assert called(package, "rigrunner", "upgrade", "example/procedure.yaml").returncode == 0
    words = ("run", "example/procedure.yaml", "--station", "example/station.yaml", "--unattended")
    done = called(package, "rigrunner", *words, "--runs", str(tmp_path / "runs"))
    assert done.returncode == 0, done.stdout + done.stderr
    assert list((tmp_path / "runs").glob("*/run.h5"))
