"""Commands that other packages provide."""

from __future__ import annotations

from importlib.metadata import EntryPoint

import click
import pytest

from rigrunner.cli import package_commands as module
from rigrunner.cli.lazy import LazyGroup
from rigrunner.cli.main import main
from rigrunner.cli.package_commands import GROUP, Commands, package_commands

MODULE = """
import click

@click.command(name="{name}")
def command():
    click.echo("{text}")
"""


@pytest.fixture
def packages(tmp_path, monkeypatch):
    """Return a function that makes a package with one command."""
    monkeypatch.syspath_prepend(tmp_path)

    def make(package, name, text, title="Extras"):
        folder = tmp_path / package
        folder.mkdir()
        (folder / "__init__.py").write_text(f"COMMANDS = {{{title!r}: {{{name!r}: {text!r}}}}}\n")
        (folder / f"{name}.py").write_text(MODULE.format(name=name, text=text))
        return Commands(package, {title: {name: text}})

    return make


def output_of(group, name):
    lines = []
    with click.Context(group) as context:
        command = group.get_command(context, name)
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(click, "echo", lines.append)
            command.main([], standalone_mode=False)
    return lines


def test_command_of_a_package_is_listed_in_its_group_and_runs(packages):
    core = packages("mine", "first", "Do the first.", "Run")
    package = packages("theirs", "second", "Do the second.", "Run")
    group = LazyGroup(own=core, others=lambda: [package])
    assert group.groups == {"Run": {"first": "Do the first.", "second": "Do the second."}}
    assert output_of(group, "second") == ["Do the second."]


def test_own_command_wins_over_a_package_command(packages):
    core = packages("mine_too", "same", "Mine.", "Run")
    package = packages("theirs_too", "same", "Theirs.")
    group = LazyGroup(own=core, others=lambda: [package])
    assert group.summaries == {"same": "Mine."}
    assert output_of(group, "same") == ["Mine."]


def test_packages_are_not_searched_for_an_own_command(packages):
    def fail():
        raise AssertionError

    group = LazyGroup(own=packages("alone", "only", "Alone."), others=fail)
    assert output_of(group, "only") == ["Alone."]


def test_import_error_of_a_package_is_reported_and_the_help_still_works(monkeypatch, capsys):
    entry = EntryPoint("broken", "there_is_no_such_package", GROUP)
    monkeypatch.setattr(module, "entries", lambda _: {"broken": entry})
    assert list(package_commands()) == []
    assert main(["--help"]) == 0
    output = capsys.readouterr()
    assert "the commands of 'broken' cannot be loaded: No module named" in output.err
    assert "resume" in output.out
