"""Loads a station from a file or a stored text."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from rigrunner.api.errors import InvalidFileError, Problem
from rigrunner.api.instruments import STORED
from rigrunner.api.member import Member
from rigrunner.station.fixing import as_if_fixed
from rigrunner.station.model import Station
from rigrunner.yamlfile import parse, validate
from rigrunner.yamlfile.document import dotted
from rigrunner.yamlfile.problems import suggestion
from rigrunner.yamlfile.reader import read_text
from rigrunner.yamlfile.upgrade import refuse_older
from rigrunner.yamlfile.upgrade_register import current_station

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator
    from pathlib import Path

    from rigrunner.api.instruments import Instrument
    from rigrunner.yamlfile import Document


@dataclass(frozen=True, eq=False)
class LoadedStation:
    """A station, the places of its parts, and its text."""

    model: Station
    document: Document
    digest: str
    """SHA-256 of the text in UTF-8, hexadecimal."""
    text: str
    time_limits: bool = True
    """Whether calls of devices have time limits; not under a debugger."""

    @property
    def register(self) -> dict[str, Instrument]:
        """The register of instruments by channel, 'role.name'."""
        return {instrument.channel: instrument for instrument in self.model.instruments}


class InconsistentStationError(InvalidFileError):
    """Parts of a station are wrong; `loaded` has replacements, to check further."""

    def __init__(self, problems: Iterable[Problem], loaded: LoadedStation) -> None:
        super().__init__(problems)
        self.loaded = loaded


def load_station(path: Path) -> LoadedStation:
    """Return the station in a file; raise InvalidFileError with all problems."""
    return parse_station(read_text(path), str(path))


def parse_station(text: str, name: str, *, stored: bool = False) -> LoadedStation:
    """Return the station in a text; `name` is its file in messages.

    The text of a `stored` run may be in an older form, and have limits of error that its version
    misread. Raises InvalidFileError with all problems.
    """
    document = parse(text, name)
    if stored:
        document = replace(document, data=current_station(document.data))
    else:
        refuse_older(document)
    problems: list[Problem] = []
    model: Station | None = None
    try:
        model = validate(Station, document, context={STORED: stored})
    except InvalidFileError as error:
        problems = list(error.problems)
        model, more = as_if_fixed(document, problems)
        problems += more
    devices_are_valid = not any(problem.field.startswith("devices") for problem in problems)
    problems += _register_problems(document, sure_of_roles=devices_are_valid)
    if model is None:
        raise InvalidFileError(problems)
    loaded = LoadedStation(model, document, hashlib.sha256(text.encode()).hexdigest(), text)
    if problems:
        raise InconsistentStationError(problems, loaded)
    return loaded


def _register_problems(document: Document, *, sure_of_roles: bool) -> Iterator[Problem]:
    """Yield problems of the channels of the register, also if other parts are wrong.

    An unknown role follows from a wrong device, and is not reported then.
    """
    devices = document.part(("devices",))
    roles = list(devices) if isinstance(devices, dict) else []
    channels: set[str] = set()
    for index in range(len(document.part(("instruments",)) or ())):
        path = ("instruments", index, "channel")
        channel = document.part(path)
        try:
            role = Member.parse(str(channel)).role
        except ValueError:  # reported by the model
            continue
        location, field = document.where(path), dotted(path)
        if sure_of_roles and role not in roles:
            hint = suggestion(role, roles, "roles")
            yield Problem(f"there is no device in the role '{role}'", location, field, hint)
        if channel in channels:
            yield Problem(f"'{channel}' is registered twice", location, field)
        channels.add(channel)
