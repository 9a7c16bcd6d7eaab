"""Files that a procedure names: procedures that it calls, pictures that it shows.

Whatever a file says, nothing outside of its own folder is looked at.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.errors import RigrunnerError, did_you_mean

if TYPE_CHECKING:
    from pathlib import Path

_LONGEST = 80
PICTURES = (".png", ".jpg", ".jpeg", ".svg", ".gif", ".webp")


class FileBesideError(RigrunnerError):
    """A file that is named cannot be had."""


def file_beside(folder: Path, name: str) -> Path:
    """Return the file of that relative name in a folder or below; raise FileBesideError."""
    path = folder / name
    try:
        inside = _looks_inside(name) and path.resolve().is_relative_to(folder.resolve())
        there = inside and path.is_file()
    except (OSError, RuntimeError) as error:  # a name that is too long, links in a circle
        reason = getattr(error, "strerror", None) or "links lead in a circle"
        raise FileBesideError(f"'{name[:_LONGEST]}' cannot be looked up: {reason}") from error
    if not inside:
        hint = "name a file beside this one, or in a folder below"
        raise FileBesideError(f"'{name[:_LONGEST]}' leads out of this file's folder", hint=hint)
    if not there:
        raise FileBesideError(f"there is no file '{name[:_LONGEST]}'", hint=_near(path))
    return path


def picture_beside(folder: Path, name: str) -> Path:
    """Return the picture of that relative name; raise FileBesideError."""
    path = file_beside(folder, name)
    if path.suffix.lower() not in PICTURES:
        raise FileBesideError(f"'{name}' is not a picture", hint=f"allowed: {', '.join(PICTURES)}")
    return path


def _looks_inside(name: str) -> bool:
    """Say whether a name stays inside, also on systems where backslash and colon separate."""
    parts = name.replace("\\", "/").split("/")
    return ".." not in parts and bool(parts[0]) and ":" not in name


def _near(path: Path) -> str:
    names = [each.name for each in path.parent.glob("*")] if path.parent.is_dir() else []
    return did_you_mean(path.name, names, f"looked in {path.parent}")
