"""Checks on lab folders that `rigrunner init` makes."""

from __future__ import annotations

from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

from rigrunner.api.errors import RigrunnerError
from rigrunner.clock import SimulatedClock
from rigrunner.run.prepare import plan_run
from rigrunner.tools.labfolder import STATION, make_lab
from rigrunner_testing.check import AnyCheck, Nonconformity, check, demand

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigrunner_testing.subjects import Subject


@check(fix="put station.yaml and README.md into `files`, and name shipped procedures")
def is_whole(subject: Subject) -> None:
    """It has a station, a page that describes its files, and a procedure to run first."""
    with _lab(subject) as (folder, procedures):
        missing = [name for name in (STATION, "README.md") if not (folder / name).is_file()]
        demand(not missing, f"it has no {' and no '.join(missing)}")
        demand(procedures, "it has no procedure")


@check(fix="try it: `rigrunner init`, then `rigrunner check` each procedure", needs=("is_whole",))
def can_be_run_at_once(subject: Subject) -> None:
    """Each procedure in it can be planned on its station."""
    with _lab(subject) as (folder, procedures):
        for procedure in procedures:
            try:
                plan_run(folder / procedure, folder / STATION, subject.registry, SimulatedClock())
            except RigrunnerError as error:
                raise Nonconformity(f"{procedure}: {error}") from error


@contextmanager
def _lab(subject: Subject) -> Iterator[tuple[Path, list[str]]]:
    with TemporaryDirectory() as folder:
        yield Path(folder), make_lab(Path(folder), subject.registry, subject.name)


CHECKS: tuple[AnyCheck, ...] = (is_whole, can_be_run_at_once)
