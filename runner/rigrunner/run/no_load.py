"""What a no-load run must have besides, to be taken from a loaded one."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.analysis.torque.channels import motion_channel
from rigrunner.analysis.torque.one_setup import setup_differences
from rigrunner.analysis.torque.sources import sources
from rigrunner.api.analysis import MotionSource
from rigrunner.api.instruments import torque_instruments
from rigrunner.api.member import Member
from rigrunner.plan.requirements import Point, no_load_problems, points_of_plan, requirers
from rigrunner.plan.selection import analysed
from rigrunner.procedure.analysis_spec import NO_LOAD, NO_LOAD_AFTER

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from rigrunner.api.data import RunData
    from rigrunner.api.devices import Device
    from rigrunner.run.prepare import Planned

_FREQUENCY_TOLERANCE = 0.005
"""How far, relatively, a set frequency of the two runs may differ and still be the same one."""


def no_load_objections(planned: Planned, name: str, partner: RunData) -> Iterator[str]:
    """Yield what speaks against a partner run of that name; nothing of one of another analysis."""
    if name not in {NO_LOAD, NO_LOAD_AFTER}:
        return
    station = planned.station
    transducers = torque_instruments(partner.instruments.values()).values()
    ours = torque_instruments(station.model.instruments)
    yield from setup_differences(partner.rig, transducers, station.rig, ours)
    yield from _lacks(planned, partner)


def _lacks(planned: Planned, partner: RunData) -> Iterator[str]:
    """Yield what the analysis needs and the recordings of the no-load run do not give."""
    found, drive = sources(partner), _cycle_drive(planned.devices)
    needed = requirers(planned.procedure.model, planned.registry)
    there = [each.setpoints.get(drive, 0.0) for each in found]
    yield from _missing_frequencies(there, _frequencies_hz(planned))
    points = [
        Point(hz, loaded=False, shows_phase=motion_channel(each)[0] is not MotionSource.ENTERED)
        for hz, each in zip(there, found, strict=True)
    ]
    yield from (message for _, message, _ in no_load_problems(needed, points))
    least = max((each.needs.cycles for each in needed), default=0)
    for hz, each in zip(there, found, strict=True):
        whole = int(each.samples / each.rate_hz * hz) - 1 if each.samples > 1 else least
        if whole < least:
            yield f"its recording {each.name} has {whole} cycles, but {least} are needed"


def _frequencies_hz(planned: Planned) -> list[float]:
    points = points_of_plan(analysed(planned.plan, planned.procedure))
    return sorted({point.frequency_hz for point in points if point.frequency_hz > 0})


def _missing_frequencies(there: Sequence[float], wanted_hz: Sequence[float]) -> Iterator[str]:
    missing = [
        wanted
        for wanted in wanted_hz
        if not any(abs(has - wanted) <= _FREQUENCY_TOLERANCE * wanted for has in there)
    ]
    if missing:
        yield f"it has no recording at {', '.join(f'{hz:g} Hz' for hz in missing)}"


def _cycle_drive(devices: Mapping[str, Device]) -> str:
    """Return the drive that sets the cycle frequency; '' where there is none."""
    names = (
        Member(role, drive.name)
        for role, device in devices.items()
        for drive in device.drives
        if drive.sets_cycle_frequency
    )
    return next(names, "")
