"""What the doctor finds, on a machine that is well and on one that is not."""

from __future__ import annotations

import shutil
import sys
from collections import namedtuple
from datetime import UTC, datetime, timedelta
from importlib.metadata import PackageNotFoundError, version

import pytest
from matplotlib import font_manager

from rigrunner.api.hooks import FitRecord
from rigrunner.registry import DisabledPlugin, Plugin, Provider, Registry, load_registry
from rigrunner.workflow import doctor
from rigrunner.workflow.doctor import Surroundings, examine

NOW = datetime(2026, 12, 1, 12, tzinfo=UTC)
FIT = FitRecord(name="straight", help="A line", factory=lambda _: None)


def found(name, runs, *, registry=None, now=NOW):
    well = Registry([Plugin("fit", FIT, Provider("lab", "1"))])
    findings = examine(Surroundings(runs, registry or well, now))
    return [finding for finding in findings if finding.name == name]


def only(name, runs, **changes):
    (finding,) = found(name, runs, **changes)
    return finding


def test_here_nothing_that_is_needed_is_missing(tmp_path):
    findings = examine(Surroundings(tmp_path, load_registry(), datetime.now(UTC)))
    assert [finding for finding in findings if finding.state == "fail"] == []
    assert len({finding.name for finding in findings}) == len(doctor.CHECKS)


def test_whatever_is_not_ok_says_how_to_mend_it(tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    broken = Registry([], [DisabledPlugin(Provider("lab", "1"), "ImportError: no driver")])
    findings = examine(Surroundings(tmp_path, broken, datetime(1970, 1, 1, tzinfo=UTC)))
    assert {finding.state for finding in findings} == {"ok", "warn", "fail"}
    assert [
        finding.name for finding in findings if (finding.state == "ok") == bool(finding.mend)
    ] == []


def test_a_python_that_is_too_old_fails(tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "version_info", (3, 10, 9))
    finding = only("Python", tmp_path)
    assert (finding.state, finding.mend) == ("fail", "install Python 3.11 or newer")


def test_a_package_that_is_missing_or_too_old_fails(tmp_path, monkeypatch):
    def changed(name):
        if name == "h5py":
            raise PackageNotFoundError(name)
        return "2.6.9" if name == "pydantic" else version(name)

    monkeypatch.setattr(doctor, "version", changed)
    failed = [finding.found for finding in found("packages", tmp_path) if finding.state == "fail"]
    assert failed == ["h5py is missing", "pydantic 2.6.9 is too old"]


@pytest.mark.parametrize(
    ("installed", "least", "enough"),
    [
        ("8.1.0", "8.1", True),
        ("8.10", "8.9", True),
        ("8.0.9", "8.1", False),
        ("3.11.0rc1", "3.11", True),
        ("1.26.4+local.2", "1.26", True),
    ],
)
def test_versions_are_compared_as_numbers(installed, least, enough):
    assert (doctor._numbers(installed) >= doctor._numbers(least)) is enough


def test_a_disabled_plugin_is_named_with_its_reason(tmp_path):
    disabled = [DisabledPlugin(Provider("lab", "1"), "ImportError: no driver")]
    registry = Registry([Plugin("fit", FIT, Provider("other", "2"))], disabled)
    first, second = found("plugins", tmp_path, registry=registry)
    assert (first.state, first.found) == ("ok", "1 of other 2")
    assert (second.state, second.found) == ("warn", "lab 1 is disabled: ImportError: no driver")


def test_a_name_that_two_claim_is_named_with_both(tmp_path):
    registry = Registry(Plugin("fit", FIT, Provider(name, "1")) for name in ("a", "b"))
    finding = found("plugins", tmp_path, registry=registry)[-1]
    assert (finding.state, finding.found) == ("warn", "fit 'straight' is provided by a 1 and b 1")


def test_no_plugins_at_all_fail(tmp_path):
    assert only("plugins", tmp_path, registry=Registry([])).state == "fail"


@pytest.mark.parametrize(
    ("now", "state"),
    [
        (NOW, "ok"),
        (NOW - timedelta(hours=2), "warn"),
        (NOW - timedelta(minutes=30), "ok"),
        (datetime(1970, 1, 1, tzinfo=UTC), "fail"),
    ],
)
def test_a_clock_that_is_behind_is_noticed(tmp_path, now, state):
    (tmp_path / f"{NOW:%Y%m%dT%H%M%SZ}_SSPB-NLI").mkdir()
    (tmp_path / "20250101T000000Z_OLD").mkdir()
    (tmp_path / "something else").mkdir()
    assert only("clock", tmp_path, now=now).state == state


def test_the_runs_folder_need_not_be_there_yet(tmp_path):
    finding = only("runs folder", tmp_path / "deep" / "runs")
    assert finding.state == "ok"
    assert finding.found.endswith("will be made by the first run")
    assert list(tmp_path.iterdir()) == []


def test_a_runs_folder_that_cannot_be_written_fails(tmp_path, monkeypatch):
    def refuse(**_):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(doctor.tempfile, "TemporaryFile", refuse)
    finding = only("runs folder", tmp_path)
    assert (finding.state, finding.found) == ("fail", f"{tmp_path}: Permission denied")


@pytest.mark.parametrize(("free_bytes", "state"), [(11e9, "ok"), (1e9, "warn"), (0.1e9, "fail")])
def test_a_disk_that_is_nearly_full_is_noticed(tmp_path, monkeypatch, free_bytes, state):
    usage = namedtuple("usage", "total used free")  # noqa: PYI024  (what shutil returns)
    monkeypatch.setattr(shutil, "disk_usage", lambda _: usage(0, 0, int(free_bytes)))
    assert only("disk", tmp_path).state == state


def test_a_missing_font_fails(tmp_path, monkeypatch):
    def refuse(*_, **__):
        raise ValueError("no such font")

    monkeypatch.setattr(font_manager, "findfont", refuse)
    assert only("fonts", tmp_path).state == "fail"


def test_a_library_that_does_not_work_is_a_finding_and_no_traceback(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "h5py", None)
    finding = only("hdf5", tmp_path)
    assert finding.state == "fail"
    assert finding.found.startswith("ModuleNotFoundError: ")


def test_programs_that_are_optional_only_warn(tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    assert only("browser", tmp_path).state == "warn"
    assert only("editor support", tmp_path).state == "warn"
    program = tmp_path / "yaml-language-server"
    program.touch(mode=0o755)
    assert only("editor support", tmp_path).found == str(program)


@pytest.mark.parametrize(
    ("name", "package", "mend"),
    [
        ("PDF", "weasyprint", "pip install 'rigrunner[pdf]', for certificates as PDF"),
        (
            "signatures",
            "cryptography",
            "pip install 'rigrunner[sign]', to sign certificates and to check who signed",
        ),
    ],
)
def test_an_extra_that_is_not_installed_only_warns(tmp_path, monkeypatch, name, package, mend):
    assert only(name, tmp_path).state == "ok"
    monkeypatch.setitem(sys.modules, package, None)
    finding = only(name, tmp_path)
    assert (finding.state, finding.mend) == ("warn", mend)
