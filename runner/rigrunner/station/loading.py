"""From a file, or a stored text, to a station."""

from __future__ import annotations

import difflib
import hashlib
from dataclasses import dataclass
from typing import TYPE_CHECKING

from rigrunner.api.errors import InvalidFileError, Problem
from rigrunner.api.instruments import torque_instruments
from rigrunner.station.model import Station
from rigrunner.yamlfile import parse, validate
from rigrunner.yamlfile.document import dotted
from rigrunner.yamlfile.reader import read_text

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from rigrunner.api.instruments import Instrument, TorqueInstrument
    from rigrunner.yamlfile import Document


@dataclass(frozen=True, eq=False)
class LoadedStation:
    """A station, where each part of it stands, and the text that it was read from."""

    model: Station
    document: Document
    digest: str
    """SHA-256 of the text in UTF-8, hexadecimal."""
    text: str

    @property
    def register(self) -> dict[str, Instrument]:
        """The instrument register by channel, 'role.name'."""
        return {each.channel: each for each in self.model.instruments}

    @property
    def instruments(self) -> dict[str, TorqueInstrument]:
        """The torque transducers of the register by channel."""
        return torque_instruments(self.model.instruments)


def load_station(path: Path) -> LoadedStation:
    """Return the station in that file; raise InvalidFileError with all that is wrong in it."""
    return parse_station(read_text(path), str(path))


def parse_station(text: str, name: str) -> LoadedStation:
    """Return the station in a text; `name` stands for the file in messages.

    Raises InvalidFileError with all that is wrong.
    """
    document = parse(text, name)
    model = validate(Station, document)
    problems = list(_register_problems(model, document))
    if problems:
        raise InvalidFileError(problems)
    return LoadedStation(model, document, hashlib.sha256(text.encode()).hexdigest(), text)


def _register_problems(station: Station, document: Document) -> Iterator[Problem]:
    seen: set[str] = set()
    for index, instrument in enumerate(station.instruments):
        path = ("instruments", index, "channel")
        where, field = document.where(path), dotted(path)
        role = instrument.channel.partition(".")[0]
        if role not in station.devices:
            near = difflib.get_close_matches(role, station.devices, n=1)
            hint = f"did you mean '{near[0]}'?" if near else f"roles: {', '.join(station.devices)}"
            yield Problem(f"there is no device in the role '{role}'", where, field, hint)
        if instrument.channel in seen:
            yield Problem(f"'{instrument.channel}' is registered twice", where, field)
        seen.add(instrument.channel)
