"""Whether a no-load run can be taken from a loaded one, asked before that is made."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.instruments import torque_instruments
from rigrunner_bearings.api.points import MotionSource
from rigrunner_bearings.api.rig import planned_rig, rig_of
from rigrunner_bearings.torque.channels import motion_channel
from rigrunner_bearings.torque.one_setup import setup_differences
from rigrunner_bearings.torque.requirers import analysed, points_of, requirers
from rigrunner_bearings.torque.sources import sources

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from rigrunner.api import AnalysisContext, Recording, RunData
    from rigrunner.api.planned import PlannedRun
    from rigrunner_bearings.torque.requirers import Requirer
    from rigrunner_bearings.torque.settings import TorqueSettings

_FREQUENCY_TOLERANCE = 0.005
"""How far, relatively, a set frequency of the two runs may differ and still be the same one."""


def partner_problems(
    spec: TorqueSettings, planned: PlannedRun, partner: RunData, context: AnalysisContext
) -> Iterator[str]:
    """Yield what speaks against a no-load run: another set-up, or what its recordings lack."""
    transducers = torque_instruments(partner.instruments.values()).values()
    ours = torque_instruments(planned.instruments)
    rig = planned_rig(planned)
    yield from setup_differences(rig_of(partner), transducers, rig, ours)
    found = sources(partner)
    there = [each.setpoints.get(planned.cycle_drive or "", 0.0) for each in found]
    wanted_hz = {each.frequency_hz for each in points_of(analysed(planned, spec))}
    yield from _missing_frequencies(there, sorted(wanted_hz - {0.0}))
    needed = requirers(spec, context.plugins)
    yield from _unmet(needed, there, found)
    least = max(each.needs.cycles for each in needed)
    for hz, each in zip(there, found, strict=True):
        whole = int(each.samples / each.rate_hz * hz) - 1 if each.samples > 1 else least
        if whole < least:
            yield f"its recording {each.name} has {whole} cycles, but {least} are needed"


def _missing_frequencies(there: Sequence[float], wanted_hz: Sequence[float]) -> Iterator[str]:
    missing = [
        wanted
        for wanted in wanted_hz
        if not any(abs(has - wanted) <= _FREQUENCY_TOLERANCE * wanted for has in there)
    ]
    if missing:
        yield f"it has no recording at {', '.join(f'{hz:g} Hz' for hz in missing)}"


def _unmet(
    needed: Sequence[Requirer], there: Sequence[float], found: Sequence[Recording]
) -> Iterator[str]:
    """Yield which parts need more frequencies, or the crank phase, than the run has."""
    frequencies = sorted(set(there))
    shows_phase = all(motion_channel(each)[0] is not MotionSource.ENTERED for each in found)
    for name, needs in ((each.name, each.needs) for each in needed):
        if len(frequencies) < needs.points:
            got = ", ".join(f"{hz:g} Hz" for hz in frequencies) or "none"
            yield f"{name} needs {needs.points} different frequencies without load, got {got}"
        if needs.phase and not shows_phase:
            yield f"{name} needs the crank phase, and without load nothing shows it"
