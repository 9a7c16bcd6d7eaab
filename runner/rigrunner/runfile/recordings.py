"""One recording as a NeXus NXdata group that viewers plot at once."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api.data import Block, Recording
from rigrunner.api.errors import DataError
from rigrunner.runfile.coordinates import (
    read_coordinates,
    read_written,
    write_coordinates,
    write_written,
)
from rigrunner.runfile.digest import RecordingDigest
from rigrunner.runfile.hdf5 import free_name, read_values, write_values
from rigrunner.runfile.stored_samples import StoredSamples
from rigrunner.signal.blocks import blocks, limits_of

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

    import h5py

    from rigrunner.api.coordinates import Coordinate
    from rigrunner.api.data import Array, Samples
    from rigrunner.api.events import StepEnded, StepStarted
    from rigrunner.runfile.scratch import Scratch

_CHUNK = 16_384
"""Samples: 128 KiB of doubles."""
_FILTERS = {"compression": "gzip", "compression_opts": 1, "shuffle": True, "fletcher32": True}
"""Filters that every HDF5 has; others are faster, but readers need a plugin for them."""
_AXIS = "time"
_POSITIONS = ("rad", "m")
"""Units of channels that say where the others were read."""


@dataclass(frozen=True)
class RecordingFacts:
    """A recording without its samples."""

    name: str
    number: int
    """Its index in the run's order of recordings."""
    rate_hz: float
    channels: tuple[str, ...]
    samples: int
    started_utc: str
    complete: bool
    setpoints: Mapping[str, float] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)
    conditions: Mapping[str, float] = field(default_factory=dict)
    coordinates: Mapping[str, Coordinate] = field(default_factory=dict)
    written_in: Mapping[str, str] = field(default_factory=dict)

    def recording(self, channels: Mapping[str, Samples]) -> Recording:
        """Return the recording with these samples."""
        return Recording(
            name=self.name,
            rate_hz=self.rate_hz,
            started_utc=self.started_utc,
            setpoints=self.setpoints,
            channels=channels,
            units=self.units,
            conditions=self.conditions,
            coordinates=self.coordinates,
            written_in=self.written_in,
        )

    def digest(self) -> RecordingDigest:
        """Return the digest, to which samples are then added."""
        units = {channel: self.units.get(channel, "") for channel in self.channels}
        units |= {name: self.units[name] for name in self.coordinates if name in self.units}
        digest = RecordingDigest(self.name, self.rate_hz, self.setpoints, units, self.coordinates)
        # A channel of which no sample came is in the digest too: no block adds it.
        digest.update({channel: np.empty(0) for channel in self.channels})
        return digest


@dataclass(frozen=True)
class Shape:
    """What the blocks of a recording have in common, and the number of their samples."""

    rate_hz: float
    channels: tuple[str, ...]
    samples: int


def facts_of(
    number: int, shape: Shape, started: StepStarted, ended: StepEnded | None
) -> RecordingFacts:
    """Return the facts on a recording from the events of its step and its blocks."""
    end = ended if ended is not None and ended.ok else None
    return RecordingFacts(
        name=started.recording,
        number=number,
        rate_hz=shape.rate_hz,
        channels=shape.channels,
        samples=shape.samples,
        started_utc=started.utc,
        complete=end is not None,
        setpoints=started.setpoints,
        units={**started.units, **(end.units if end else {})},
        conditions=end.values if end else {},
        coordinates=started.coordinates,
        written_in={
            name: symbol
            for name, symbol in started.written_in.items()
            if name in started.setpoints or name in started.coordinates or name in shape.channels
        },
    )


def write_recording(group: h5py.Group, facts: RecordingFacts, blocks: Iterable[Block]) -> None:
    """Write a recording into an empty group; memory does not grow with its length.

    Raises DataError if the blocks have another number of samples than the facts.
    """
    _write_facts(group, facts)
    time = group.create_dataset(_AXIS, (facts.samples,), "<f8", **_storage(facts))
    time.attrs.update({"units": "s", "long_name": "time / s"})
    columns = {name: _new_column(group, name, facts) for name in facts.channels}
    # What a viewer plots first: the first channel that is no position, or else the first.
    signals = [name for name in facts.channels if facts.units.get(name) not in _POSITIONS]
    for name in (signals or list(facts.channels))[:1]:
        group.attrs.update({"signal": columns[name].name.rpartition("/")[2], "axes": [_AXIS]})
    digest, at = facts.digest(), 0
    for channels, count in _in_chunks(blocks, facts.channels):
        for name, values in channels.items():
            columns[name][at : at + count] = values
        time[at : at + count] = np.arange(at, at + count) / facts.rate_hz
        digest.update(channels)
        at += count
    if at != facts.samples:
        raise DataError(
            f"recording '{facts.name}': only {at} samples can be read back, not {facts.samples}",
            hint="its journal was damaged after it was written: is the disk sound?",
        )
    group.attrs["sha256"] = digest.hexdigest()


def read_facts(group: h5py.Group) -> RecordingFacts:
    """Read a recording without its samples."""
    return _facts(group, _columns(group))


def _facts(group: h5py.Group, columns: Mapping[str, h5py.Dataset]) -> RecordingFacts:
    setpoints, setpoint_units = read_values(group["setpoints"])
    conditions, condition_units = read_values(group["conditions"])
    coordinates, coordinate_units = read_coordinates(group)
    units = {
        name: str(item.attrs["units"]) for name, item in columns.items() if "units" in item.attrs
    }
    return RecordingFacts(
        name=str(group.attrs["name"]),
        number=int(group.attrs["number"]),
        rate_hz=float(group.attrs["rate_hz"]),
        channels=tuple(columns),
        samples=int(group.attrs["samples"]),
        started_utc=str(group.attrs["started_utc"]),
        complete=bool(group.attrs["complete"]),
        setpoints=setpoints,
        units={**setpoint_units, **condition_units, **coordinate_units, **units},
        conditions=conditions,
        coordinates=coordinates,
        written_in={
            **{
                name: str(item.attrs["shown_in"])
                for name, item in columns.items()
                if "shown_in" in item.attrs
            },
            **read_written(group),
        },
    )


def stored_bytes(groups: Iterable[h5py.Group]) -> int:
    """Return the memory of the samples of some recordings, in bytes."""
    return sum(item.nbytes for group in groups for item in group.values() if "column" in item.attrs)


def read_recording(
    group: h5py.Group, scratch: Scratch | None = None
) -> tuple[RecordingFacts, Recording]:
    """Read a recording, with its facts; raise DataError if it differs from its digest.

    With a `scratch` its samples stay in the file, and are decompressed by slices.
    """
    columns = _columns(group)
    facts = _facts(group, columns)
    channels: dict[str, Samples] = {}
    digest = facts.digest()
    for name, column in columns.items():
        if scratch is None:
            channels[name] = values = np.asarray(column[()], np.float64)
            digest.update({name: values})
        else:
            parts = _digested_parts(column, name, digest)
            # This walks through the parts, and so adds them to the digest.
            limits = limits_of(parts) if len(column) else None
            channels[name] = StoredSamples.of(column, Path(group.file.filename), limits, scratch)
    if digest.hexdigest() != group.attrs["sha256"]:
        raise DataError(
            f"{group.file.filename}: recording '{facts.name}' is not what was recorded:"
            " its SHA-256 does not match",
            hint="'rigrunner recover --salvage' saves the other recordings",
        )
    return facts, facts.recording(channels)


def _digested_parts(column: h5py.Dataset, name: str, digest: RecordingDigest) -> Iterator[Array]:
    """Yield the samples of a column in parts, each of which is added to the digest."""
    for _, part in blocks(column):
        digest.update({name: part})
        yield part


def assemble(facts: RecordingFacts, blocks: Iterable[Block]) -> tuple[Recording, str]:
    """Return a recording from its blocks, in memory, and its digest."""
    parts = [channels for channels, _ in _in_chunks(blocks, facts.channels)]
    channels = {
        name: np.concatenate([part[name] for part in parts]) if parts else np.empty(0)
        for name in facts.channels
    }
    digest = facts.digest()
    digest.update(channels)
    return facts.recording(channels), digest.hexdigest()


def _write_facts(group: h5py.Group, facts: RecordingFacts) -> None:
    group.attrs.update(
        {
            "NX_class": "NXdata",
            "title": facts.name,
            "name": facts.name,
            "number": facts.number,
            "rate_hz": facts.rate_hz,
            "samples": facts.samples,
            "started_utc": facts.started_utc,
            "complete": np.uint8(facts.complete),
        }
    )
    write_values(group, "setpoints", facts.setpoints, facts.units)
    write_values(group, "conditions", facts.conditions, facts.units)
    if facts.coordinates:
        write_coordinates(group, facts.coordinates, facts.units)
    write_written(group, facts.written_in)


def _new_column(group: h5py.Group, channel: str, facts: RecordingFacts) -> h5py.Dataset:
    name, unit = free_name(group, channel), facts.units.get(channel)
    column = group.create_dataset(name, (facts.samples,), "<f8", **_storage(facts))
    column.attrs.update({"name": str(channel), "column": facts.channels.index(channel)})
    column.attrs["long_name"] = f"{channel} / {unit}" if unit else str(channel)
    if unit is not None:
        column.attrs["units"] = unit
    if channel in facts.written_in:
        column.attrs["shown_in"] = facts.written_in[channel]
    return column


def _columns(group: h5py.Group) -> dict[str, h5py.Dataset]:
    """Return the channels' datasets by channel, in recorded order."""
    columns = sorted(
        (item for item in group.values() if "column" in item.attrs),
        key=lambda item: int(item.attrs["column"]),
    )
    return {str(item.attrs["name"]): item for item in columns}


def _storage(facts: RecordingFacts) -> dict[str, object]:
    # HDF5 refuses a chunk that is larger than its dataset, and one of no samples.
    return {"chunks": (min(facts.samples, _CHUNK),), **_FILTERS} if facts.samples else {}


def _in_chunks(
    blocks: Iterable[Block], names: tuple[str, ...]
) -> Iterator[tuple[dict[str, Array], int]]:
    """Join small blocks: the overhead of a write is far larger than its data."""
    waiting: list[Block] = []
    count = 0
    for block in blocks:
        waiting.append(block)
        count += block.samples
        if count >= _CHUNK:
            yield _join(waiting, names), count
            waiting, count = [], 0
    if count:
        yield _join(waiting, names), count


def _join(blocks: list[Block], names: tuple[str, ...]) -> dict[str, Array]:
    if any(set(block.channels) != set(names) for block in blocks):
        raise DataError(f"a block of samples has other channels than {', '.join(names)}")
    return {name: np.concatenate([block.channels[name] for block in blocks]) for name in names}
