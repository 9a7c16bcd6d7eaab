"""Finds procedures, stations and runs by path, or by name among the shipped ones."""

from __future__ import annotations

import difflib
from pathlib import Path

from rigrunner.api.errors import UsageError, did_you_mean

RUN_FILE = "run.h5"
_OTHER_FILES = {".csv", ".html", ".json", ".pdf", ".yaml", ".yml"}
MOST_NAMED = 12
"""Number of runs named in a message, the newest."""


def shipped_folder() -> Path:
    """Return the folder of the shipped procedures, in the wheel or in a source checkout."""
    package = Path(__file__).resolve().parent.parent
    packaged = package / "shipped"
    return packaged if packaged.is_dir() else package.parent.parent / "procedures"


def find_procedure(name_or_path: str) -> Path:
    """Return the procedure file of that path or shipped name; raise UsageError."""
    return _find(name_or_path, shipped_folder(), "procedure")


def find_station(name_or_path: str) -> Path:
    """Return the station file of that path or shipped name; raise UsageError."""
    return _find(name_or_path, shipped_folder() / "stations", "station")


def procedure_names() -> list[str]:
    """Return the names of the shipped procedures."""
    return _names(shipped_folder())


def station_names() -> list[str]:
    """Return the names of the shipped stations."""
    return _names(shipped_folder() / "stations")


def find_run(name_or_path: str, runs: Path) -> Path:
    """Return the run folder of that path, or of that name in the folder of runs; raise UsageError.

    A `run.h5` stands for its folder; a unique prefix of a name is enough.
    """
    # A path wins over the name of a run.
    for candidate in (Path(name_or_path), runs / name_or_path):
        if candidate.is_dir() or candidate.is_file():
            if candidate.is_file() and candidate.suffix.lower() in _OTHER_FILES:
                hint = (
                    f"a run is its folder in {runs}, or the {RUN_FILE} in it; see 'rigrunner runs'"
                )
                raise UsageError(f"{candidate} is not a run", hint=hint)
            return candidate.parent if candidate.name == RUN_FILE else candidate
    names = run_names(runs)
    matches = [name for name in names if name.startswith(name_or_path)]
    if len(matches) == 1:
        return runs / matches[0]
    if matches:
        raise UsageError(f"'{name_or_path}' could be any of: {_listed(matches)}")
    raise UsageError(f"there is no run '{name_or_path}' in {runs}", hint=_near(name_or_path, names))


def run_names(runs: Path) -> list[str]:
    """Return the names of all run folders, oldest first (a name begins with its UTC time)."""
    if not runs.is_dir():
        return []
    return sorted(
        entry.name for entry in runs.iterdir() if entry.is_dir() and entry.name[:1] != "."
    )


def _find(name_or_path: str, folder: Path, what: str) -> Path:
    path = Path(name_or_path)
    if path.is_file():
        return path
    shipped = folder / f"{name_or_path}.yaml"
    if path.name == name_or_path and shipped.is_file():
        return shipped
    if path.is_dir():
        raise UsageError(
            f"'{name_or_path}' is a folder, not a {what} file",
            hint=f"YAML files in it: {', '.join(_files(path)) or 'none'}",
        )
    hint = _near_file(path) or _near(name_or_path, _names(folder))
    raise UsageError(f"there is no {what} '{name_or_path}'", hint=hint)


def _names(folder: Path) -> list[str]:
    return sorted(path.stem for path in folder.glob("*.yaml"))


def _files(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.glob("*.yaml"))


def _near_file(path: Path) -> str:
    """Suggest a similar file beside it, to a bare name only that of this name."""
    if path.parent != Path() and not path.parent.is_dir():
        return f"there is no folder {path.parent}"
    files = {Path(name).stem: path.with_name(name) for name in _files(path.parent)}
    cutoff = 0.7 if path.suffix else 1.0
    matches = difflib.get_close_matches(path.stem, files, n=1, cutoff=cutoff)
    return f"did you mean '{files[matches[0]]}'?" if matches else ""


def _near(name: str, names: list[str]) -> str:
    return did_you_mean(name, names, f"there are: {_listed(names)}", cutoff=0.5)


def _listed(names: list[str]) -> str:
    if len(names) > MOST_NAMED:
        return f"{', '.join(names[-MOST_NAMED:])}, the last {MOST_NAMED} of {len(names)}"
    return ", ".join(names) or "none"
