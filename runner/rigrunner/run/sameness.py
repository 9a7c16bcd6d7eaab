"""Whether a run can be resumed: with the files, software and instruments of its start."""

from __future__ import annotations

from itertools import zip_longest
from typing import TYPE_CHECKING

from rigrunner.api.errors import DataError
from rigrunner.plan import plan_text
from rigrunner.run.provenance import identities, software

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

    from rigrunner.api.devices import Identity
    from rigrunner.run.prepare import Planned
    from rigrunner.runfile import RunHeader

DEVICE = "device "
"""Prefix of instruments in the provenance of a run."""
_SHOWN = 60


def check_same(header: RunHeader, planned: Planned) -> None:
    """Raise DataError with everything that changed since the start; no rig is needed."""
    _refuse(header, _differences(header, planned))


def check_same_instruments(header: RunHeader, identified: Mapping[str, Identity]) -> None:
    """Raise DataError if other instruments answer than at the start."""
    before = {name: text for name, text in header.provenance.items() if name.startswith(DEVICE)}
    _refuse(header, _changed(before, identities(identified)))


def _refuse(header: RunHeader, differences: Iterable[str]) -> None:
    found = list(differences)
    if found:
        raise DataError(
            f"{header.run_id} cannot be resumed, as not all is as it was: {'; '.join(found)}",
            hint="put back what was changed, or close the run as it is: 'rigrunner recover'",
        )


def _differences(header: RunHeader, planned: Planned) -> Iterator[str]:
    procedure, station = planned.procedure, planned.station
    yield from _text_change("the procedure", header.procedure_text, procedure.text)
    called = procedure.called_texts
    for name in sorted({*header.called_texts, *called}):
        before = header.called_texts.get(name, "")
        yield from _text_change(f"the called {name}", before, called.get(name, ""))
    yield from _text_change("the station", header.station_text, station.text)
    software_before = {
        name: text for name, text in header.provenance.items() if not name.startswith(DEVICE)
    }
    found = list(_changed(software_before, software(planned.registry)))
    yield from found
    same_texts = (header.procedure_text, header.station_text) == (procedure.text, station.text)
    if same_texts and not found and header.plan_text != plan_text(planned.plan):
        yield "the same files give another plan: a plugin of the station was changed"


def _text_change(what: str, before: str, now: str) -> Iterator[str]:
    """Yield the first difference of a text, if there is one."""
    lines = zip_longest(before.splitlines(), now.splitlines(), fillvalue="")
    for number, (old, new) in enumerate(lines, start=1):
        if old != new:
            yield f"{what} in line {number} was '{_short(old)}', is '{_short(new)}'"
            return
    if before != now:
        yield f"{what} has other line ends"


def _changed(before: Mapping[str, str], now: Mapping[str, str]) -> Iterator[str]:
    for name in sorted({*before, *now}):
        old, new = before.get(name, "none"), now.get(name, "none")
        if old != new:
            yield f"{name} was {old}, is {new}"


def _short(line: str) -> str:
    text = line.strip()
    return text if len(text) <= _SHOWN else f"{text[:_SHOWN]}..."
