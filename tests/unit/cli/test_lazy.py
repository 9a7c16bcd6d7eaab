"""What each command may import: the list is exact, so that nothing heavy comes in by the way."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from rigrunner.cli.main import rigrunner

PROCEDURE = "starting_torque_1000n"
EVENTS = {"msgspec", "typing_extensions"}
MODELS = {"annotated_types", "pydantic", "pydantic_core", "typing_inspection"} | EVENTS
COMMANDS_OF_BEARINGS = {"rigrunner_bearings"}
PLUGINS = {"pluggy", "rigrunner_plugins", "rigrunner_reports"} | COMMANDS_OF_BEARINGS
OURS = {"rigrunner", "rigrunner_fleet", "rigrunner_panel", "rigrunner_testing"}
FLOORS = {"api", "blas", "cli", "moved", "printable", "run"}

HELP = ({"click"} | COMMANDS_OF_BEARINGS, FLOORS)
"""Other packages than those of Python and ours, and the floors of ours."""
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
OF_COMPILERS = ("_cython", "cython_", "_sysconfigdata")
"""How the modules begin that compiled code and Python bring along."""


def modules_of(*arguments):
    """The modules that a call imports."""
    return modules_after(f"main({list(arguments)!r})")


def modules_after(calls):
    code = (
        "import sys; from rigrunner.cli.main import main, rigrunner\n"
        f"{calls}\n"
        "print('IMPORTED', *sys.modules)"
    )
    done = subprocess.run(
        [sys.executable, "-S", "-c", f"import sys; sys.path[:] = {sys.path!r}\n{code}"],
        cwd=Path(__file__).parent,  # the reader of a checkout may have runs in it
        capture_output=True,
        text=True,
        check=True,
    )
    return set(done.stdout.rpartition("IMPORTED")[2].split())


def packages_and_floors(modules):
    tops = {name.partition(".")[0] for name in modules} - set(sys.stdlib_module_names)
    others = {name for name in tops if not name.startswith(OF_COMPILERS)} - {"__main__"}
    floors = {name.split(".")[1] for name in modules if name.startswith("rigrunner.")}
    return others - OURS, floors


@pytest.mark.parametrize("arguments", COMMANDS, ids=" ".join)
def test_a_command_imports_no_more_than_is_listed(arguments):
    modules = modules_of(*arguments)
    packages, floors = packages_and_floors(modules)
    may_be_packages, of_ours = COMMANDS[arguments]
    assert packages <= may_be_packages
    assert floors == of_ours
    assert not {name for name in modules if name.endswith(".moved")} - {"rigrunner.moved"}


def test_the_help_of_no_command_imports_a_package_beside_click_and_that_of_events():
    modules = modules_after(
        f"for name in {list(rigrunner.summaries)!r}: rigrunner.get_command(None, name)\n"
        "studies = rigrunner.get_command(None, 'study')\n"
        "for name in studies.list_commands(None): studies.get_command(None, name)"
    )
    assert "rigrunner_bearings.commands.study.coverage" in modules
    packages, floors = packages_and_floors(modules)
    assert packages == {"click"} | COMMANDS_OF_BEARINGS | EVENTS
    assert floors <= FLOORS | {"signal"}


def test_a_check_loads_no_settings_but_those_of_plugins_that_are_named():
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


def test_the_settings_of_all_plugins_load_and_build_without_numpy():
    modules = modules_after(
        "from rigrunner.registry import load_registry\n"
        "for plugin in load_registry().plugins: plugin.record.settings_model.model_rebuild()"
    )
    assert "rigrunner_plugins.devices.daq.settings" in modules
    assert packages_and_floors(modules)[0] <= LIST[0]


def test_no_model_is_built_before_it_is_used():
    """A default that is an instance of a model would build it: `Field(default_factory=...)`."""
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
def test_every_command_says_first_what_the_list_of_commands_says(name):
    command = rigrunner.get_command(None, name)
    assert command.name == name
    assert command.help.partition("\n")[0] == rigrunner.summaries[name]


def test_a_report_needs_no_model_of_a_certificate_and_looks_for_no_plugins_of_pydantic():
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
def test_what_records_and_analyses_begins_without_the_packages_of_scipy(module):
    """They take longest, and come in with the first analysis: a run without one needs none."""
    modules = modules_after(f"import {module}")
    assert "scipy" in modules
    packages = {"special", "ndimage", "signal", "stats", "optimize", "interpolate", "integrate"}
    assert not {f"scipy.{name}" for name in packages} & modules
    assert "sqlalchemy" not in modules, "the archive is asked for by few"
