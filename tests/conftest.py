"""What tests of several packages share."""

from __future__ import annotations

import atexit
import gc
import json
import os
import pickle
import platform
import shutil
import signal
import sys
import tempfile
from dataclasses import asdict, dataclass
from functools import lru_cache
from pathlib import Path

import pytest
from filelock import FileLock
from hypothesis import HealthCheck, settings

# The matrices are small: several threads of BLAS only spin, here and in what the tests start.
# numpy reads it once it is imported.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
# A container may set this. Workers and programs of tests would then compile everything again.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
# The guard compares numbers to 1e-9. Kernels of other processors move some by 3e-4 of U.
if platform.machine() == "x86_64":
    os.environ.setdefault("OPENBLAS_CORETYPE", "Haswell")

from e2e.helpers_served import served_command
from helpers_cli import Called, call, shell
from helpers_figures import BLANK_FIGURES, blank, drawn
from helpers_tester import both, installed
from helpers_thorough import ALL_EXAMPLES, FEWER_EXAMPLES
from helpers_workflow import START, quick_procedure, run
from rigrunner.api import units
from rigrunner.clock import SimulatedClock
from rigrunner.registry.installed import installed as providers

# No test cuts the power, and a run syncs a hundred times: what is written is not waited for here.
# Like fsync this fails for a file that is closed. Tests of what is synced, and when, put their own.
os.fsync = os.fstat
# How long an example takes is a matter of what else the machine does.
settings.register_profile(ALL_EXAMPLES, deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.register_profile(FEWER_EXAMPLES, settings.get_profile(ALL_EXAMPLES), max_examples=33)
settings.load_profile(ALL_EXAMPLES)

pytest_plugins = ["rigrunner_testing.pytest_plugin"]


@pytest.fixture(autouse=True)
def _units_of_a_test():
    """Let no unit that a test defines be known to another one."""
    before = {spelling: dict(claims) for spelling, claims in units._ADDED.items()}
    yield
    if before != units._ADDED:
        units._ADDED.clear()
        units._ADDED.update(before)
        units._composed.cache_clear()


@pytest.fixture(scope="session", autouse=True)
def _providers_looked_up_once():
    """Look up what is installed once for each sys.path: half of what loading a registry takes."""

    @lru_cache
    def found(_path):
        return providers()

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("rigrunner.registry.loading.installed", lambda: found((*sys.path,)))
        yield


def pytest_addoption(parser) -> None:
    """Add the option that CI passes."""
    parser.addoption("--all", action="store_true", help="run the thorough tests too, as CI does")


def pytest_xdist_auto_num_workers(config) -> int:
    """Return how many workers run the tests: two more than processors, as some tests wait.

    Files that are named are run in this process, which saves to start workers.
    """
    if _files_are_named(config):
        return 0
    all_ours = hasattr(os, "sched_getaffinity")
    return 2 + (len(os.sched_getaffinity(0)) if all_ours else os.cpu_count() or 1)


def _files_are_named(config) -> bool:
    return not any(Path(each).is_dir() for each in config.args)


def pytest_configure(config) -> None:
    """Give each worker of pytest-xdist folders for temporary files and for the state of rigs alone.

    A rig is locked for all programs of a machine by its station's id, and several tests at once
    have stations of one id. Markers of rigs on this machine are no concern of the tests. Tests
    interrupt themselves and what they start: a shell that starts pytest in the background has it
    ignore SIGINT and SIGQUIT.
    """
    if not (config.option.all or _files_are_named(config)):
        settings.load_profile(FEWER_EXAMPLES)
    gc.disable()  # until all is collected, which stays to the end
    signal.signal(signal.SIGINT, signal.default_int_handler)
    if hasattr(signal, "SIGQUIT"):
        signal.signal(signal.SIGQUIT, signal.SIG_DFL)
    # else each of the thousand programs that tests start compiles all again
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
    worker = os.environ.get("PYTEST_XDIST_WORKER")
    if worker or not config.getoption(
        "numprocesses", None
    ):  # in no worker, only for what it starts
        path = (str(BLANK_FIGURES), os.environ.get("PYTHONPATH"))
        os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, path))
    rigs = tempfile.mkdtemp(prefix="rigrunner-tests-rigs-")
    atexit.register(shutil.rmtree, rigs, ignore_errors=True)
    os.environ["RIGRUNNER_LOCKS"] = rigs
    if worker:
        folder = Path(tempfile.gettempdir()) / f"rigrunner-tests-{os.getppid()}-{worker}"
        folder.mkdir(exist_ok=True)
        os.environ["TMPDIR"] = str(folder)
        tempfile.tempdir = None  # it is looked up again


def pytest_collection_modifyitems(config, items) -> None:
    """Begin with the tests that wait in real time: other workers run the rest meanwhile.

    The thorough ones are left out, except with `--all` and where their files are named.
    """
    if not (config.option.all or _files_are_named(config)):
        left_out = [item for item in items if item.get_closest_marker("thorough")]
        config.hook.pytest_deselected(items=left_out)
        items[:] = [item for item in items if not item.get_closest_marker("thorough")]
    items.sort(key=lambda item: item.get_closest_marker("in_real_time") is None)


def pytest_collection_finish() -> None:
    """Look for garbage less often, and not in what collecting made, which stays to the end."""
    gc.freeze()
    gc.enable()
    gc.set_threshold(20_000, *gc.get_threshold()[1:])


@dataclass(frozen=True)
class Runs:
    """A no-load run and a loaded one, made once for all workers: to be read, not written to."""

    folder: Path
    no_load: Path
    loaded: Path


@dataclass(frozen=True)
class Demo(Runs):
    """The demonstration, and what it printed."""

    called: Called


@pytest.fixture(scope="session")
def made_once(tmp_path_factory, worker_id):
    """Return a folder by its name; the first worker that asks for it fills it by a function.

    Figures are left blank, unless the function draws them.
    """
    base = tmp_path_factory.getbasetemp()
    shared = base if worker_id == "master" else base.parent

    def made(name, fill) -> Path:
        folder, done = shared / name, shared / f"{name}.done"
        with FileLock(shared / f"{name}.lock"):
            if not done.exists():
                folder.mkdir()
                with blank():
                    fill(folder)
                done.touch()
        return folder

    return made


@pytest.fixture(scope="session")
def computed_once(made_once):
    """Return what a function gives, by a name; the first worker that asks for it computes it."""

    def computed(name, function):
        def fill(folder) -> None:
            (folder / "value").write_bytes(pickle.dumps(function()))

        return pickle.loads((made_once(name, fill) / "value").read_bytes())  # noqa: S301  (our own)

    return computed


@pytest.fixture(scope="session")
def demo(made_once) -> Demo:
    """Run `rigrunner demo`."""

    def fill(folder) -> None:
        with drawn():
            called = call("demo", "--dir", folder / "runs")
        assert called.code == 0, called.err
        (folder / "called.json").write_text(json.dumps(asdict(called)), encoding="utf-8")

    folder = made_once("demo", fill)
    called = Called(**json.loads((folder / "called.json").read_text(encoding="utf-8")))
    return Demo(folder / "runs", *sorted((folder / "runs").iterdir()), called)


@dataclass(frozen=True)
class Lab:
    """A lab folder, the commands that `init` printed for it, and what they printed, done as told.

    To be copied, not written to.
    """

    folder: Path
    commands: str
    printed: str


@pytest.fixture(scope="session")
def lab_begun(made_once) -> Lab:
    """Make a lab folder by `rigrunner init`, and run what that prints, in a shell."""

    def fill(folder) -> None:
        with served_command() as served:
            commands = shell(folder, "rigrunner init 'bench 1'", served).stdout
            printed = shell(folder, commands, served).stdout
        (folder / "commands").write_text(commands, encoding="utf-8")
        (folder / "printed").write_text(printed, encoding="utf-8")

    folder = made_once("lab", fill)
    texts = ((folder / name).read_text(encoding="utf-8") for name in ("commands", "printed"))
    return Lab(folder / "bench 1", *texts)


@pytest.fixture(scope="session")
def quick(made_once) -> Runs:
    """Run what ships at fewer frequencies and with fewer cycles: a tenth of the demonstration."""

    def fill(folder) -> None:
        clock = SimulatedClock(START)
        for name in ("no_load_inertia_sweep", "starting_torque_1000n"):
            done = run(quick_procedure(folder, name), folder / "runs", clock=clock)
            assert done.error is None, done.error

    folder = made_once("quick", fill)
    return Runs(folder / "runs", *sorted((folder / "runs").iterdir()))


@pytest.fixture(scope="module")
def quick_copy(quick, tmp_path_factory) -> Runs:
    """Copy the quick runs for one module, which may write to them."""
    runs = shutil.copytree(quick.folder, tmp_path_factory.mktemp("quick") / "runs")
    return Runs(runs, *sorted(runs.iterdir()))


@dataclass(frozen=True)
class TesterRuns:
    """Runs of the tests' own tester, without load and loaded: to be read, not written to."""

    folder: Path
    idle: Path
    loaded: Path


@pytest.fixture(scope="module")
def tester():
    """Have the package of the tests' own tester installed."""
    with installed():
        yield


@pytest.fixture(scope="session")
def tester_runs(made_once) -> TesterRuns:
    """Run the tests' own tester without load, and then loaded."""

    def fill(folder) -> None:
        with installed():
            for done in both(folder):
                assert done.error is None, done.error

    folder = made_once("tester", fill)
    return TesterRuns(folder / "runs", *sorted((folder / "runs").iterdir()))


@pytest.fixture(scope="module")
def tester_runs_copy(tester_runs, tmp_path_factory) -> TesterRuns:
    """Copy the tester's runs for one module, which may write to them."""
    runs = shutil.copytree(tester_runs.folder, tmp_path_factory.mktemp("tester") / "runs")
    return TesterRuns(runs, *sorted(runs.iterdir()))


@pytest.fixture(scope="module", autouse=True)
def _blank_figures(request):
    """Leave figures blank, except in modules marked `figures`.

    Of the runs that are made once for many tests the demonstration has them.
    """
    with drawn() if request.node.get_closest_marker("figures") else blank():
        yield


@pytest.fixture(scope="module")
def without_pdf():
    """Issue certificates without a PDF, as where WeasyPrint is missing.

    Each would be laid out twice, on trial and with its number.
    """
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(sys.modules, "weasyprint", None)
        yield


@pytest.fixture
def drawn_figures():
    """Draw the figures of one test."""
    with drawn():
        yield
