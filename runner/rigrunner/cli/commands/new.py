"""`rigrunner new`: create a plugin that works at once."""

from __future__ import annotations

import shlex
from pathlib import Path

import click

from rigrunner.cli.output import message, result

PLUGINS = "plugins"
"""The folder of a lab's own plugins, as `rigrunner init` makes it."""


@click.command(name="new")
@click.argument("kind")
@click.argument("name")
@click.option(
    "--drop-in", is_flag=True, help="Create one file in a lab's folder instead of a package."
)
@click.option(
    "--folder",
    type=click.Path(path_type=Path, file_okay=False),
    help="Where to create it; by default 'rigrunner-NAME', with --drop-in 'plugins'.",
)
def command(kind: str, name: str, folder: Path | None, *, drop_in: bool) -> None:
    """Create a plugin that works at once.

    It creates an installable package with tests and a README, or with --drop-in one file. KIND is
    device, fit, outlier-rule, rule, analysis, importer, report, step or unit, or a kind that a
    package brings. NAME is what procedures and stations call it. No file is overwritten.
    """
    from rigrunner.registry import load_registry, with_drop_ins
    from rigrunner.tools.new_plugin import make_drop_in, make_package, new_plugin

    registry = load_registry()
    plugin = new_plugin(kind, name, registry)
    if drop_in:
        target = folder or Path(PLUGINS)
        with_lab = with_drop_ins(registry, target) if target.is_dir() else registry
        files = make_drop_in(plugin, target, with_lab)
        message(f"Created {target / files[0]}. A station says 'plugins: {target.name}'. To try it:")
        result(f"rigrunner check-plugin {name} --drop-in {shlex.quote(str(target))}")
        return
    target = folder or Path(plugin.project)
    files = make_package(plugin, target, registry)
    message(f"Created {target} with {', '.join(files)}. To try it:")
    result(f"cd {shlex.quote(str(target))}")
    result("pip install -e '.[test]'")
    result("pytest && mypy && ruff check")
    result(f"rigrunner check-plugin {name}")
    if kind == "device":
        result("rigrunner run example/procedure.yaml --station example/station.yaml --unattended")
