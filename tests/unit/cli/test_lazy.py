from __future__ import annotations

import subprocess
import sys

import pytest

from rigrunner.cli.main import SUMMARIES, rigrunner

MAY_BE_IMPORTED = {"click", "rigrunner"}


def modules_of(*arguments):
    """The modules that a call imports."""
    code = (
        "import sys; from rigrunner.cli.main import main\n"
        f"main({list(arguments)!r})\n"
        "print('IMPORTED', *sys.modules)"
    )
    done = subprocess.run(
        [sys.executable, "-S", "-c", f"import sys; sys.path[:] = {sys.path!r}\n{code}"],
        capture_output=True,
        text=True,
        check=True,
    )
    return set(done.stdout.rpartition("IMPORTED")[2].split())


def imported_by(*arguments):
    """The top-level packages from outside the standard library that a call imports."""
    names = {name.partition(".")[0] for name in modules_of(*arguments)}
    return {name for name in names if name not in sys.stdlib_module_names and name != "__main__"}


@pytest.mark.parametrize("option", ["--help", "--version", "-h"])
def test_help_and_version_import_next_to_nothing(option):
    assert imported_by(option) <= MAY_BE_IMPORTED


@pytest.mark.parametrize("options", [(), ("--station", "simulated")])
def test_to_check_imports_nothing_that_only_results_need(options):
    heavy = {
        "GTC",
        "cryptography",
        "matplotlib",
        "scipy.interpolate",
        "scipy.optimize",
        "scipy.signal",
        "scipy.stats",
        "weasyprint",
    }
    assert modules_of("check", "starting_torque_1000n", *options) & heavy == set()


@pytest.mark.parametrize("name", SUMMARIES)
def test_every_command_says_first_what_the_list_of_commands_says(name):
    command = rigrunner.get_command(None, name)
    assert command.name == name
    assert command.help.partition("\n")[0] == SUMMARIES[name]
