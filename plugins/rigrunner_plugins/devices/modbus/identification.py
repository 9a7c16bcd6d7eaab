"""Who answers, and whether it is the instrument that the station means."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from rigrunner.api import DeviceNotFoundError, Identity
from rigrunner_plugins.devices.modbus.grouping import Span

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigrunner_plugins.devices.modbus.places import Number
    from rigrunner_plugins.devices.modbus.settings import IdentityPart, ModbusSettings

_NOT_TOLD = "not told"


class Asks(Protocol):
    """Asks the unit."""

    def read_numbers(self, numbers: Sequence[Number]) -> list[float]:
        """Return numbers."""
        ...

    def read_words(self, wanted: Span) -> list[int]:
        """Return registers."""
        ...

    def read_identification(self) -> list[str]:
        """Return maker, product and revision."""
        ...


def identify(settings: ModbusSettings, unit: Asks) -> Identity:
    """Return who answers; raise DeviceNotFoundError if it is another one than expected.

    Where the station says nothing of its identity, a first number is read: a serial port opens
    also with nothing behind it.
    """
    wanted = settings.identification
    texts = dict.fromkeys(("maker", "model", "serial", "firmware"), "")
    if wanted.standard:
        texts["maker"], texts["model"], texts["firmware"] = unit.read_identification()
    asked = {"model": wanted.model, "serial": wanted.serial, "firmware": wanted.firmware}
    texts |= {name: _text(part, unit) for name, part in asked.items() if part is not None}
    if not any(texts.values()):
        unit.read_numbers([_first(settings)])
    for name, expected in wanted.expect.items():
        if texts[name] != expected:
            raise DeviceNotFoundError(
                f"{settings.where} has the {name} '{texts[name]}', expected '{expected}'",
                hint="is it another instrument, or must the station be updated?",
            )
    return Identity(
        maker=texts["maker"] or _NOT_TOLD,
        model=texts["model"] or f"Modbus {settings.where}",
        serial=texts["serial"] or _NOT_TOLD,
        firmware=texts["firmware"],
        simulated=settings.simulated,
    )


def _text(part: IdentityPart, unit: Asks) -> str:
    if part.text is None:
        return f"{unit.read_numbers([part])[0]:.10g}"
    return text_at(part, part.text, unit)


def text_at(number: Number, registers: int, unit: Asks) -> str:
    """Return the text that stands in so many registers."""
    words = unit.read_words(Span(number.table, number.address, registers, number.unit_id))
    raw = b"".join(word.to_bytes(2, number.byte_order) for word in words)
    return raw.decode("ascii", "replace").strip("\0 ")


def _first(settings: ModbusSettings) -> Number:
    if settings.channels:
        return next(iter(settings.channels.values()))
    if not settings.drives:
        return next(iter(settings.readings.values()))
    drive = next(iter(settings.drives.values()))
    return drive.read_back or drive
