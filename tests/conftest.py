"""What tests of several packages share."""

from __future__ import annotations

import gc
import json
import os
import tempfile
from dataclasses import asdict, dataclass
from pathlib import Path

import pytest
from filelock import FileLock

# The matrices are small: several threads of BLAS only spin, here and in what the tests start.
# numpy reads it once it is imported.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from helpers_cli import Called, call

pytest_plugins = ["rigrunner.testing.pytest_plugin"]


def pytest_configure() -> None:
    """Give each worker of pytest-xdist a folder for temporary files, and so locks of rigs, alone.

    A rig is locked for all programs of a machine by its station's id, and several tests at once
    have stations of one id.
    """
    worker = os.environ.get("PYTEST_XDIST_WORKER")
    if worker:
        folder = Path(tempfile.gettempdir()) / f"rigrunner-tests-{os.getppid()}-{worker}"
        folder.mkdir(exist_ok=True)
        os.environ["TMPDIR"] = str(folder)
        tempfile.tempdir = None  # it is looked up again


def pytest_collection_modifyitems(items) -> None:
    """Begin with the tests that wait in real time: other workers run the rest meanwhile."""
    items.sort(key=lambda item: item.get_closest_marker("in_real_time") is None)


def pytest_collection_finish() -> None:
    """Take what collecting made, which stays to the end, out of what garbage is looked for in."""
    gc.freeze()


@dataclass(frozen=True)
class Demo:
    """The demonstration, run once: its folder, its two runs, and what it printed."""

    folder: Path
    no_load: Path
    loaded: Path
    called: Called


@pytest.fixture(scope="session")
def demo(tmp_path_factory, worker_id) -> Demo:
    """Run `rigrunner demo`, once for all workers; treat its folder as read-only."""
    base = tmp_path_factory.getbasetemp()
    shared = base if worker_id == "master" else base.parent
    folder, told = shared / "demo" / "runs", shared / "demo.json"
    with FileLock(shared / "demo.lock"):
        if not told.exists():
            called = call("demo", "--dir", folder)
            assert called.code == 0, called.err
            told.write_text(json.dumps(asdict(called)), encoding="utf-8")
    no_load, loaded = sorted(folder.iterdir())
    return Demo(folder, no_load, loaded, Called(**json.loads(told.read_text(encoding="utf-8"))))
