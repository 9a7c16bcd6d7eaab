"""The manifest: which file was recorded at which set-points.

    rigrunner: replay/1
    recordings:
      - {frequency: 0 Hz, load: 0 N, values: {torque: 0.01 N·m}}
      - {frequency: 1 Hz, load: 0 N, file: no_load_01.csv}
      - {frequency: 1 Hz, load: 1 kN, file: all.h5, group: /loaded/01, values: {temperature: 23 °C}}

`values` are constants of channels that the file does not hold.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import Field, ValidationError

from rigrunner.api import AnyQuantity, Force, Frequency, ListOf, Location, Settings, unit
from rigrunner.api.errors import InvalidFileError, Problem
from rigrunner.api.units import with_article
from rigrunner_plugins.devices.replay.texts import read_texts

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence
    from pathlib import Path

    from rigrunner_plugins.devices.replay.settings import ColumnSettings
    from rigrunner_plugins.devices.replay.texts import Texts

Where = tuple[int | str, ...]
CLOSE = 1e-6
"""Relative difference up to which two set-points are the same."""


class RecordingEntry(Settings):
    """One recording and the set-points at which it was made."""

    frequency: Annotated[Frequency, Field(ge=0)]
    load: Annotated[Force, Field(ge=0)]
    file: Annotated[str, Field(min_length=1)] | None = None
    group: Annotated[str, Field(description="HDF5: group that the columns' paths start from")] = "/"
    values: dict[str, AnyQuantity] = Field(default_factory=dict)

    def is_at(self, frequency_hz: float, load_n: float) -> bool:
        """Return whether it was made at these set-points."""
        return _is_same(self.frequency, frequency_hz) and _is_same(self.load, load_n)

    def __str__(self) -> str:
        """Return the set-points as they are listed in messages."""
        return f"{self.frequency:g} Hz at {self.load:g} N"


class Manifest(Settings):
    """All recordings of a folder."""

    rigrunner: Literal["replay/1"]
    recordings: Annotated[ListOf[RecordingEntry], Field(min_length=1)]


def load_manifest(folder: Path, name: str, channels: Mapping[str, ColumnSettings]) -> Manifest:
    """Read a manifest and check that each file is there, inside the folder.

    Raises InvalidFileError with all problems. No recording's content is looked at.
    """
    path = inside(folder, name)
    if path is None or not path.is_file():
        problem = "leads out of the folder" if path is None else "there is no such file"
        raise InvalidFileError([Problem(problem, Location(str(folder / name)))])
    texts = read_texts(path)
    try:
        manifest = Manifest.model_validate(texts.data)
    except ValidationError as error:
        raise InvalidFileError(_model_problems(texts, error)) from None
    problems = [
        Problem(message, texts.location(path), _dotted(path))
        for index, entry in enumerate(manifest.recordings)
        for path, message in _entry_problems(manifest.recordings, index, folder, channels)
    ]
    if problems:
        raise InvalidFileError(problems)
    return manifest


def inside(folder: Path, name: str) -> Path | None:
    """Return the path of that name in the folder, or None if it leads out of it."""
    path = (folder / name).resolve()
    return path if path.is_relative_to(folder.resolve()) else None


def _model_problems(texts: Texts, error: ValidationError) -> Iterator[Problem]:
    for details in error.errors(include_url=False, include_context=False, include_input=False):
        path, message = details["loc"], details["msg"].removeprefix("Value error, ")
        if details["type"] == "missing":
            message = "is missing"
        elif details["type"] == "extra_forbidden":
            model = Manifest if len(path) == 1 else RecordingEntry
            message = f"is unknown; known are {', '.join(model.model_fields)}"
        yield Problem(message, texts.location(path), _dotted(path))


def _entry_problems(
    entries: Sequence[RecordingEntry],
    index: int,
    folder: Path,
    channels: Mapping[str, ColumnSettings],
) -> Iterator[tuple[Where, str]]:
    entry = entries[index]
    if entry.file is not None:
        path = inside(folder, entry.file)
        if path is None or not path.is_file():
            problem = "leads out of the folder" if path is None else "is not there"
            yield ("recordings", index, "file"), f"'{entry.file}' {problem}"
    elif not entry.values:
        yield ("recordings", index), "has neither a file nor values"
    for name, quantity in entry.values.items():
        where = ("recordings", index, "values", name)
        if name not in channels:
            yield where, f"there is no channel '{name}'; there are: {', '.join(channels)}"
        elif quantity.dimension != (dimension := unit(channels[name].unit).dimension):
            yield (
                where,
                (
                    f"'{quantity}' is {with_article(quantity.dimension)}, but"
                    f" {with_article(dimension)} is needed"
                ),
            )
    if any(other.is_at(entry.frequency, entry.load) for other in entries[:index]):
        yield ("recordings", index), f"{entry} is given twice"


def _dotted(path: Where) -> str:
    steps = (f"[{step}]" if isinstance(step, int) else f".{step}" for step in path)
    return "".join(steps).removeprefix(".")


def _is_same(a: float, b: float) -> bool:
    return abs(a - b) <= CLOSE * max(abs(a), abs(b))
