"""What each command may import: the lists are exact, so that no heavy import slips in."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from rigrunner.cli.main import rigrunner

PROCEDURE = "starting_torque_1000n"
EVENTS = {"msgspec", "typing_extensions"}
MODELS = {"annotated_types", "pydantic", "pydantic_core", "typing_inspection"} | EVENTS
BEARINGS = {"rigrunner_bearings"}
PLUGINS = {"pluggy", "rigrunner_plugins", "rigrunner_reports"} | BEARINGS
OURS = {"rigrunner", "rigrunner_fleet", "rigrunner_panel", "rigrunner_testing"}
FLOORS = {"api", "blas", "cli", "moved", "printable", "run"}

HELP = ({"click"} | BEARINGS, FLOORS)
"""Third-party packages and those of plugins, and the subpackages of rigrunner."""
LIST = (
    {"click", "yaml"} | MODELS | PLUGINS,
    FLOORS | {"interlock", "procedure", "registry", "station", "steps", "yamlfile"},
)
CHECK = (LIST[0], FLOORS | {"clock", "interlock", "procedure", "registry", "steps", "yamlfile"})
CHECK_ON_STATION = (
    CHECK[0] | {"numpy"},  # the devices are made, to ask them what they can do
    CHECK[1] | {"plan", "rig", "signal", "station"},
)
COMMANDS = {
    ("--help",): HELP,
    ("-h",): HELP,
    ("--version",): HELP,
    ("check", "--help"): HELP,
    ("run", "--help"): HELP,
    ("check", PROCEDURE): CHECK,
    ("check", PROCEDURE, "--station", "simulated"): CHECK_ON_STATION,
    ("plugins",): LIST,
}
COMPILER_PREFIXES = ("_cython", "cython_", "_sysconfigdata")
"""Prefixes of the modules that compiled code and Python load themselves."""


def modules_of(*arguments):
    """Return the modules that a call imports."""
    return modules_after(f"main({list(arguments)!r})")


def modules_after(calls):
    code = (
        "import sys; from rigrunner.cli.main import main, rigrunner\n"
        f"{calls}\n"
        "print('IMPORTED', *sys.modules)"
    )
    result = subprocess.run(
        [sys.executable, "-S", "-c", f"import sys; sys.path[:] = {sys.path!r}\n{code}"],
        cwd=Path(__file__).parent,  # the root of the checkout may contain runs
        capture_output=True,
        text=True,
        check=True,
    )
    return set(result.stdout.rpartition("IMPORTED")[2].split())


def packages_and_floors(modules):
    tops = {name.partition(".")[0] for name in modules} - set(sys.stdlib_module_names)
    packages = {name for name in tops if not name.startswith(COMPILER_PREFIXES)} - {"__main__"}
    floors = {name.split(".")[1] for name in modules if name.startswith("rigrunner.")}
    return packages - OURS, floors


@pytest.mark.parametrize("arguments", COMMANDS, ids=" ".join)
def test_command_imports_only_the_listed_packages(arguments):
    modules = modules_of(*arguments)
    packages, floors = packages_and_floors(modules)
    allowed_packages, expected_floors = COMMANDS[arguments]
    assert packages <= allowed_packages
    assert floors == expected_floors
    assert not {name for name in modules if name.endswith(".moved")} - {"rigrunner.moved"}


def test_command_modules_import_only_click_and_the_event_package():
    modules = modules_after(
        f"for name in {list(rigrunner.summaries)!r}: rigrunner.get_command(None, name)\n"
        "studies = rigrunner.get_command(None, 'study')\n"
        "for name in studies.list_commands(None): studies.get_command(None, name)"
    )
    assert "rigrunner_bearings.commands.study.coverage" in modules
    packages, floors = packages_and_floors(modules)
    assert packages == {"click"} | BEARINGS | EVENTS
    assert floors <= FLOORS | {"signal"}


def test_check_loads_settings_of_named_plugins_only():
    def settings(modules):
        return {
            name
            for name in modules
            if name.startswith(("rigrunner_plugins", "rigrunner_bearings")) and "settings" in name
        }

    assert settings(modules_of("check", PROCEDURE)) == {"rigrunner_bearings.torque.settings"}
    on_station = settings(modules_of("check", PROCEDURE, "--station", "simulated"))
    assert "rigrunner_bearings.devices.swing_tester_sim.settings" in on_station
    assert not any(name.startswith("rigrunner_plugins.devices.modbus") for name in on_station)


def test_plugin_settings_load_and_build_without_numpy():
    modules = modules_after(
        "from rigrunner.registry import load_registry\n"
        "for plugin in load_registry().plugins: plugin.record.settings_model.model_rebuild()"
    )
    assert "rigrunner_plugins.devices.daq.settings" in modules
    assert packages_and_floors(modules)[0] <= LIST[0]


def test_no_model_is_built_on_import():
    """A default that is an instance of a model builds it; use `Field(default_factory=...)`."""
    modules_after(
        "import rigrunner.procedure, rigrunner.station, rigrunner.run.approval\n"
        "from rigrunner.api.settings import Settings\n"
        "from rigrunner.registry import load_registry\n"
        "for plugin in load_registry().plugins: plugin.record.settings_model\n"
        "def below(model): return {model}.union(*map(below, model.__subclasses__()))\n"
        "assert len(below(Settings)) > 100\n"
        "built = [model for model in below(Settings) if model.__pydantic_complete__]\n"
        "assert not built, built"
    )


@pytest.mark.parametrize("name", rigrunner.summaries)
def test_help_of_a_command_begins_with_its_summary(name):
    command = rigrunner.get_command(None, name)
    assert command.name == name
    assert command.help.partition("\n")[0] == rigrunner.summaries[name]


def test_report_loads_no_certificate_model_and_no_pydantic_plugins():
    loaded = modules_after(
        "main(['--version'])\n"
        "import rigrunner.run.report\n"
        "from pydantic.plugin import _loader\n"
        "assert _loader._plugins is None"
    )
    assert "rigrunner.analysis.analyse" in loaded
    assert "rigrunner.api.certificate" not in loaded


@pytest.mark.parametrize(
    "module",
    ["rigrunner.run.record", "rigrunner_panel.web.app", "rigrunner_panel.live.analyst"],
)
def test_recording_and_panel_load_no_scipy_subpackages(module):
    """They take longest to load, and only the first analysis needs them."""
    modules = modules_after(f"import {module}")
    assert "scipy" in modules
    packages = {"special", "ndimage", "signal", "stats", "optimize", "interpolate", "integrate"}
    assert not {f"scipy.{name}" for name in packages} & modules
    assert "sqlalchemy" not in modules, "the archive is asked for by few"
