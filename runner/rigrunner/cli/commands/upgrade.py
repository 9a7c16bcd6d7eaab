"""`rigrunner upgrade`: convert files of an older form of the language to the current form."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from collections.abc import Sequence


@click.command(name="upgrade")
@click.argument("files", nargs=-1, required=True, type=click.Path(path_type=Path, dir_okay=False))
@click.option(
    "--out",
    type=click.Path(path_type=Path, file_okay=False),
    metavar="FOLDER",
    help="Write the new files to this folder and keep the old ones.",
)
@click.option("--dry-run", is_flag=True, help="Show what would change, and write nothing.")
def command(files: Sequence[Path], out: Path | None, *, dry_run: bool) -> None:
    """Upgrade files of an older version of the language.

    Comments and layout stay. The old text is kept as FILE.old. The approval of a procedure must be
    renewed.
    """
    from rigrunner.cli.output import message, result
    from rigrunner.procedure import load_procedure
    from rigrunner.run.approval import approval_state
    from rigrunner.tools.upgrading import upgrade_of, write_upgrades

    upgrades = [upgrade_of(path, out) for path in files]
    needed = [upgrade for upgrade in upgrades if upgrade.is_needed]
    for upgrade in upgrades:
        if upgrade.is_needed:
            result(upgrade.diff())
        else:
            message(f"{upgrade.path} needs no upgrade.")
    if dry_run:
        message("Nothing was written.")
        return
    write_upgrades(needed)
    for upgrade in needed:
        message(f"Wrote {upgrade.target}; the older text is {upgrade.kept}.")
    # Only now that all are written, since procedures call each other.
    for upgrade in needed:
        if upgrade.is_procedure:
            loaded = load_procedure(upgrade.target)
            model, state = loaded.model, approval_state(loaded)
            result(f"{model.id}, revision {model.revision}: {state.sentence()}")
