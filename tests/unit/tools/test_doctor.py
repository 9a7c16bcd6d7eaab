"""The findings of `rigrunner doctor`."""

from __future__ import annotations

import shutil
import sys
import tomllib
from collections import namedtuple
from datetime import UTC, datetime, timedelta
from importlib.metadata import PackageNotFoundError
from pathlib import Path
from types import SimpleNamespace

import pytest
from matplotlib import font_manager

from helpers_workflow import station_file
from rigrunner.api.hooks import FitRecord
from rigrunner.registry import DisabledPlugin, Plugin, Provider, Registry, load_registry
from rigrunner.tools import doctor
from rigrunner.tools.doctor import Surroundings, drivers, examine, installation, machine

NOW = datetime(2026, 12, 1, 12, tzinfo=UTC)
FIT = FitRecord(name="straight", help="A line", factory=lambda _: None)


def findings_of(name, runs, *, registry=None, now=NOW):
    registry_with_fit = Registry([Plugin("fit", FIT, Provider("lab", "1"))])
    findings = examine(Surroundings(runs, registry or registry_with_fit, now))
    return [finding for finding in findings if finding.name == name]


def only_finding(name, runs, **changes):
    (finding,) = findings_of(name, runs, **changes)
    return finding


def test_nothing_required_is_missing_here(tmp_path):
    findings = examine(Surroundings(tmp_path, load_registry(), datetime.now(UTC)))
    assert [finding for finding in findings if finding.state == "fail"] == []
    names = {finding.name for finding in findings if not finding.name.startswith("extra")}
    assert len(names) == len(doctor.CHECKS) - 1


def test_findings_that_are_not_ok_have_a_fix(tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    broken = Registry([], [DisabledPlugin(Provider("lab", "1"), "ImportError: no driver")])
    findings = examine(Surroundings(tmp_path, broken, datetime(1970, 1, 1, tzinfo=UTC)))
    assert {finding.state for finding in findings} == {"ok", "warn", "fail"}
    assert [
        finding.name for finding in findings if (finding.state == "ok") == bool(finding.fix)
    ] == []


def test_too_old_python_fails(tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "version_info", (3, 10, 9))
    finding = only_finding("Python", tmp_path)
    assert (finding.state, finding.fix) == ("fail", "install Python 3.11 or newer")


def test_missing_old_or_defective_package_fails(tmp_path, monkeypatch):
    requirements = ["h5py>=3.11", "numpy!=2.5.4,!=2.5.5,>=1.26", "pydantic>=2.14", "click<9,>=8.1",
             "distributed>=2024.8; extra == 'dask'"]  # fmt: skip
    versions = {"numpy": "2.5.5", "pydantic": "2.6.9", "click": "8.5.1"}

    def installed_version(name):
        if name not in versions:
            raise PackageNotFoundError(name)
        return versions[name]

    monkeypatch.setattr(installation, "requires", lambda _: requirements)
    monkeypatch.setattr(installation, "version", installed_version)
    findings = findings_of("packages", tmp_path)
    assert [finding.found for finding in findings if finding.state == "fail"] == [
        "h5py is missing",
        "numpy 2.5.5 has a known defect: expected another version",
        "pydantic 2.6.9 is too old: expected 2.14",
    ]
    assert findings[1].fix == "pip install 'numpy!=2.5.4,!=2.5.5,>=1.26'"
    versions["numpy"] = "2.5.1"
    assert "numpy" not in findings_of("packages", tmp_path)[1].found


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
    assert (installation.numbers(installed) >= installation.numbers(least)) is enough


def test_disabled_plugin_is_reported_with_its_reason(tmp_path):
    disabled = [DisabledPlugin(Provider("lab", "1"), "ImportError: no driver")]
    registry = Registry([Plugin("fit", FIT, Provider("other", "2"))], disabled)
    first, second = findings_of("plugins", tmp_path, registry=registry)
    assert (first.state, first.found) == ("ok", "1 of other 2")
    assert (second.state, second.found) == ("warn", "lab 1 is disabled: ImportError: no driver")


def test_name_of_two_plugins_is_reported_with_both_providers(tmp_path):
    registry = Registry(Plugin("fit", FIT, Provider(name, "1")) for name in ("a", "b"))
    finding = findings_of("plugins", tmp_path, registry=registry)[-1]
    assert (finding.state, finding.found) == ("warn", "fit 'straight' is provided by a 1 and b 1")


def test_no_plugins_fail(tmp_path):
    assert only_finding("plugins", tmp_path, registry=Registry([])).state == "fail"


@pytest.mark.parametrize(
    ("now", "state"),
    [
        (NOW, "ok"),
        (NOW - timedelta(hours=2), "warn"),
        (NOW - timedelta(minutes=30), "ok"),
        (datetime(1970, 1, 1, tzinfo=UTC), "fail"),
    ],
)
def test_clock_behind_the_newest_run_is_noticed(tmp_path, now, state):
    (tmp_path / f"{NOW:%Y%m%dT%H%M%SZ}_SSPB-NLI").mkdir()
    (tmp_path / "20250101T000000Z_OLD").mkdir()
    (tmp_path / "something else").mkdir()
    assert only_finding("clock", tmp_path, now=now).state == state


def test_missing_runs_folder_is_ok(tmp_path):
    finding = only_finding("runs folder", tmp_path / "deep" / "runs")
    assert finding.state == "ok"
    assert finding.found.endswith("will be created by the first run")
    assert list(tmp_path.iterdir()) == []


def test_read_only_runs_folder_fails(tmp_path, monkeypatch):
    def refuse(**_):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(machine.tempfile, "TemporaryFile", refuse)
    finding = only_finding("runs folder", tmp_path)
    assert (finding.state, finding.found) == ("fail", f"{tmp_path}: Permission denied")


@pytest.mark.parametrize(("free_bytes", "state"), [(11e9, "ok"), (1e9, "warn"), (0.1e9, "fail")])
def test_nearly_full_disk_is_noticed(tmp_path, monkeypatch, free_bytes, state):
    usage = namedtuple("usage", "total used free")  # noqa: PYI024  (what shutil returns)
    monkeypatch.setattr(shutil, "disk_usage", lambda _: usage(0, 0, int(free_bytes)))
    assert only_finding("disk", tmp_path).state == state


def test_missing_font_fails(tmp_path, monkeypatch):
    def refuse(*_, **__):
        raise ValueError("no such font")

    monkeypatch.setattr(font_manager, "findfont", refuse)
    assert only_finding("fonts", tmp_path).state == "fail"


def test_import_error_of_a_library_is_a_finding(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "h5py", None)
    finding = only_finding("hdf5", tmp_path)
    assert finding.state == "fail"
    assert finding.found.startswith("ModuleNotFoundError: ")


def test_missing_optional_programs_warn(tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    assert only_finding("browser", tmp_path).state == "warn"
    assert only_finding("editor support", tmp_path).state == "warn"
    program = tmp_path / "yaml-language-server"
    program.touch(mode=0o755)
    assert only_finding("editor support", tmp_path).found == str(program)


REQUIREMENTS = [
    "numpy>=1.26",
    "pymodbus[serial]<3.17,>=3.16; extra == 'modbus'",
    "pyvisa>=1.14; extra == 'visa'",
    "pyvisa-py>=0.7; extra == 'visa'",
    "weasyprint>=62; extra == 'pdf'",
    "pytest>=8.2; extra == 'test'",
    'rigrunner[modbus,pdf]; extra == "test"',
]


@pytest.mark.parametrize(
    ("versions", "extra", "state", "text"),
    [
        ({"pymodbus": "3.16.2"}, "modbus", "ok", "pymodbus 3.16.2"),
        ({"pymodbus": "3.9.9"}, "modbus", "warn", "pymodbus 3.9.9 is too old: expected 3.16"),
        (
            {"pymodbus": "3.17.0"},
            "modbus",
            "warn",
            "pymodbus 3.17.0 is too new: expected a version below 3.17",
        ),
        ({}, "modbus", "warn", "not installed (optional): pymodbus"),
        ({"pyvisa": "1.16", "pyvisa-py": "0.8"}, "visa", "ok", "pyvisa 1.16, pyvisa-py 0.8"),
        ({"pyvisa": "1.16"}, "visa", "warn", "pyvisa-py is missing"),
        ({}, "visa", "warn", "not installed (optional): pyvisa, pyvisa-py"),
    ],
)
def test_installed_versions_are_compared_with_those_of_the_extra(  # noqa: PLR0917
    tmp_path, monkeypatch, versions, extra, state, text
):
    def installed(name):
        if name not in versions:
            raise PackageNotFoundError(name)
        return versions[name]

    monkeypatch.setattr(installation, "requires", lambda _: REQUIREMENTS)
    monkeypatch.setattr(installation, "version", installed)
    finding = only_finding(f"extra {extra}", tmp_path)
    assert (finding.state, finding.found) == (state, text)
    if state == "warn":
        assert (
            finding.fix == f"pip install 'rigrunner[{extra}]', for {installation.PURPOSES[extra]}"
        )


def test_extras_for_development_are_not_checked(tmp_path, monkeypatch):
    monkeypatch.setattr(installation, "requires", lambda _: REQUIREMENTS)
    findings = examine(Surroundings(tmp_path, Registry([]), NOW))
    names = {finding.name for finding in findings if finding.name.startswith("extra")}
    assert names == {"extra modbus", "extra pdf", "extra visa"}


def test_every_extra_has_a_purpose():
    text = (Path(__file__).parents[3] / "pyproject.toml").read_text(encoding="utf-8")
    declared = set(tomllib.loads(text)["project"]["optional-dependencies"])
    assert declared - set(installation.TOOLS) - set(installation.PURPOSES) == set()


def test_weasyprint_without_pango_warns(tmp_path, monkeypatch, capsys):
    class Broken:
        def find_spec(self, name, *_):
            if name == "weasyprint":
                sys.stdout.write("-----\nWeasyPrint could not import some external libraries.")
                raise OSError("cannot load library 'pango-1.0-0'")

    monkeypatch.setattr(installation, "requires", lambda _: REQUIREMENTS)
    monkeypatch.delitem(sys.modules, "weasyprint", raising=False)
    monkeypatch.setattr(sys, "meta_path", [Broken(), *sys.meta_path])
    finding = only_finding("extra pdf", tmp_path)
    assert finding.state == "warn"
    assert finding.found.startswith("WeasyPrint does not find the library Pango: cannot load")
    assert finding.fix.startswith("on Debian: apt install libpango")
    assert capsys.readouterr().out == ""  # the output is ours, and may be JSON


@pytest.mark.parametrize(
    ("name", "package", "extra"),
    [
        ("VISA", "pyvisa_py.highlevel", "visa"),
        ("NI-DAQmx", "nidaqmx.system", "daq"),
        ("serial ports", "serial.tools.list_ports", "serial"),
    ],
)
def test_driver_is_not_checked_without_its_extra(tmp_path, monkeypatch, name, package, extra):
    monkeypatch.setitem(sys.modules, package, None)
    finding = only_finding(name, tmp_path)
    assert (finding.state, finding.found) == (
        "ok", f"not checked: the extra {extra} is not installed",
    )  # fmt: skip


def test_interfaces_of_pyvisa_py_are_listed(tmp_path):
    pytest.importorskip("pyvisa_py")
    first = findings_of("VISA", tmp_path)[0]
    assert first.state == "ok"
    assert first.found.startswith("pyvisa-py speaks TCPIP SOCKET, TCPIP INSTR, ")


@pytest.mark.parametrize("paths", [(), ("/usr/lib/x86_64-linux-gnu/libvisa.so",)])
def test_visa_library_of_a_vendor_is_detected(tmp_path, monkeypatch, paths):
    pytest.importorskip("pyvisa_py")
    from pyvisa.ctwrapper import IVIVisaLibrary  # noqa: PLC0415  (optional)

    monkeypatch.setattr(IVIVisaLibrary, "get_library_paths", lambda: paths)
    last = findings_of("VISA", tmp_path)[-1]
    assert last.state == ("ok" if paths else "warn")
    assert ("libvisa.so" in last.found) is bool(paths)


def test_nidaqmx_reports_version_devices_or_missing_driver(tmp_path, monkeypatch):
    class Error(Exception):
        pass

    class System:
        driver_version = (24, 5, 0)
        devices = (SimpleNamespace(name="Dev1", product_type="USB-6343"),)

        @classmethod
        def local(cls):
            return cls()

    monkeypatch.setitem(sys.modules, "nidaqmx.system", SimpleNamespace(System=System))
    monkeypatch.setitem(sys.modules, "nidaqmx.errors", SimpleNamespace(Error=Error))
    assert only_finding("NI-DAQmx", tmp_path).found == "24.5.0; Dev1 (USB-6343)"
    System.devices = ()
    assert only_finding("NI-DAQmx", tmp_path).found == "24.5.0 sees no device"

    def absent(_):
        raise Error("Could not find an installation of NI-DAQmx. Please ensure ...")

    System.local = classmethod(absent)
    finding = only_finding("NI-DAQmx", tmp_path)
    assert finding.found == "no driver (optional): Could not find an installation of NI-DAQmx"
    assert finding.fix.startswith("install NI-DAQmx from ni.com")


def test_serial_port_without_permission_names_the_group(tmp_path, monkeypatch):
    ports = [SimpleNamespace(device=name) for name in ("/dev/ttyUSB1", "/dev/ttyUSB0")]
    listing = SimpleNamespace(comports=lambda: ports)
    monkeypatch.setitem(sys.modules, "serial.tools.list_ports", listing)
    monkeypatch.setattr(drivers.os, "access", lambda port, _: port == "/dev/ttyUSB0")
    monkeypatch.setattr(drivers.getpass, "getuser", lambda: "jones")
    usable, barred = findings_of("serial ports", tmp_path)
    assert (usable.state, usable.found) == ("ok", "/dev/ttyUSB0")
    assert barred.state == "warn"
    assert barred.found == "no permission to open /dev/ttyUSB1, which belongs to the group dialout"
    assert barred.fix == "sudo usermod -aG dialout jones, then log in again"
    ports.clear()
    assert only_finding("serial ports", tmp_path).found == "none is seen"


def station_finding(path, tmp_path):
    findings = examine(Surroundings(tmp_path, load_registry(), NOW, path))
    return [finding for finding in findings if finding.name == "station"]


def test_station_whose_devices_cannot_be_made_fails(tmp_path):
    (fine,) = station_finding(station_file(tmp_path), tmp_path)
    assert fine.state == "ok"
    assert "its plugins take the settings of tester" in fine.found
    broken = station_file(tmp_path, ("swing_tester_sim", "swing_tester_smi"))
    (wrong,) = station_finding(broken, tmp_path)
    assert wrong.state == "fail"
    assert "there is no device 'swing_tester_smi'" in wrong.found
    assert "did you mean 'swing_tester_sim'?" in wrong.fix
