"""Checks before the rig moves that a run will give the analysis of torque what it needs."""

from __future__ import annotations

from math import asin
from typing import TYPE_CHECKING

from rigrunner.api import Member, unit
from rigrunner.api.coordinates import CoordinateValue, coordinate_text, in_si, matches, mixed_labels
from rigrunner.api.errors import did_you_mean
from rigrunner.api.places import matches as is_place
from rigrunner.api.planned import ExpectedReading, PlanProblem, StationPart
from rigrunner_bearings.api.measurand import LimitMeasurand
from rigrunner_bearings.api.points import MotionSource
from rigrunner_bearings.api.rig import planned_rig, rig_of, torque_instruments
from rigrunner_bearings.torque.channels import INDEX, motion_channel
from rigrunner_bearings.torque.contradictions import contradictions
from rigrunner_bearings.torque.definition import kind_of
from rigrunner_bearings.torque.one_setup import setup_differences
from rigrunner_bearings.torque.requirements_of_plan import unmet_requirements
from rigrunner_bearings.torque.requirers import TORQUE, analysed, channels_of, points_of, requirers
from rigrunner_bearings.torque.sources import sources

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from rigrunner.api import AnalysisContext, Recording, RunData
    from rigrunner.api.planned import PlannedLimit, PlannedRecording, PlannedRun, RecordingAction
    from rigrunner_bearings.api.rig import RigDescription
    from rigrunner_bearings.torque.requirers import Requirer
    from rigrunner_bearings.torque.settings import TorqueSettings


_ANALYSED_IN = {"torque": TORQUE, "angle": "rad", "angular velocity": "rad/s"}
"""The units in which the analysis takes recorded channels, by dimension."""
_FREQUENCY = "frequency"


def plan_problems(
    spec: TorqueSettings, planned: PlannedRun, context: AnalysisContext
) -> list[PlanProblem]:
    """Return why the torque of a planned run cannot be analysed; raise PluginError.

    What a separate no-load run must have is checked when that run is chosen.
    """
    if problems := list(contradictions(spec)):
        return problems
    if not (spec.fits or spec.compensations):
        message = "the analysis names neither a fit nor a compensation, so it has no result"
        hint = "add 'fits: [polynomial]', or leave 'analysis' out to record only"
        return [PlanProblem(message=message, hint=hint)]
    chosen = analysed(planned, spec)
    problems = [
        *_recording_problems(spec, planned, chosen),
        *_limit_problems(spec, chosen, context),
    ]
    # Only now: a mistake above that leaves a frequency unset would be reported twice.
    problems = problems or list(_motion_problems(spec, chosen))
    return problems or list(unmet_requirements(spec, chosen, requirers(spec, context.plugins)))


def entering(spec: TorqueSettings, planned: PlannedRun, context: AnalysisContext) -> Iterator[str]:
    """Yield the channels whose values enter the torque.

    What is recorded but for index pulses, of which only the time counts; of what is measured the
    torque; and the load that is read beside, with which the torque scales. The torque comes first.
    """
    del spec, context
    for recording in planned.recordings:
        role, units = recording.record.role, recording.record.units
        names = [Member(role, name) for name in recording.record.channels if name != INDEX]
        yield from sorted(names, key=lambda name: units.get(name) != "N·m")
        if "load" in planned.devices.get(role, ()):
            yield Member(role, "load")
    for table in planned.rows:
        units = table.rows.units
        yield from (n for n in table.rows.channels if unit(units[n]).dimension == "torque")


def expects(
    spec: TorqueSettings, planned: PlannedRun, context: AnalysisContext
) -> Iterator[ExpectedReading]:
    """Yield the torque and the angle to be expected in each recording of a swing."""
    del context
    rig = planned_rig(planned)
    highest = (limit.highest for limit in planned.limits if limit.of == spec.name)
    bearing_nm = max((bound.si for bound in highest if bound is not None), default=0.0)
    for recording in planned.recordings:
        record = recording.record
        if not record.cycle_frequency_hz:
            continue
        rig_nm = rig_torque_nm(rig, record.cycle_frequency_hz)
        if rig_nm is not None:
            text = f"recording {record.name} is expected to reach"
            for name in channels_of(record, "torque"):
                yield _plus_minus(record, name, rig_nm + bearing_nm, text)
        if rig.swings:
            half_swing = asin(rig.eccentric_ratio)
            for name in channels_of(record, "angle"):
                yield _plus_minus(record, name, half_swing, "the swing goes to")


def rig_torque_nm(rig: RigDescription, frequency_hz: float) -> float | None:
    """Return an upper estimate of what the rig itself puts on the sensor; None: it is not known.

    Inertia, friction and damping of the supports at their greatest, which do not fall together:
    J max|alpha| + T0 + b max|omega| (torque balance of the spindle; Wang et al. 2025, section 2).
    """
    if rig.inertia is None or rig.support_friction is None or rig.support_damping is None:
        return None
    if not rig.swings:
        return None
    ratio = rig.eccentric_ratio
    from rigrunner_bearings.signal.kinematics import max_acceleration, max_speed  # noqa: PLC0415  (numpy)

    inertia_nm = rig.inertia * max_acceleration(frequency_hz, ratio)
    damping_nm = rig.support_damping * max_speed(frequency_hz, ratio)
    return inertia_nm + rig.support_friction + damping_nm


def _plus_minus(record: RecordingAction, name: str, value: float, text: str) -> ExpectedReading:
    return ExpectedReading(
        recording=record.name, channel=Member(record.role, name), low=-value, high=value, text=text
    )


def _recording_problems(
    spec: TorqueSettings, planned: PlannedRun, chosen: PlannedRun
) -> Iterator[PlanProblem]:
    if not (planned.recordings or planned.rows):
        yield PlanProblem(message="there is no recording to analyse", hint="add a record step")
    for recording in chosen.recordings:
        yield from _channel_problems(recording)
    yield from _selection_problems(spec, planned, chosen)
    if spec.starts is None and chosen.recordings:
        # By the law of the crank swings are read.
        rig = planned_rig(planned)
        for key in ("eccentric", "centre_distance"):
            if getattr(rig, key) is None:
                message = f"the analysis needs the key '{key}' of the rig, which is missing"
                yield PlanProblem(message=message, key=(key,), of=StationPart.RIG, at_key=True)
    for recording in chosen.recordings:
        for name in channels_of(recording.record, "torque"):
            yield from _instrument_problems(planned, Member(recording.record.role, name), recording)


def _channel_problems(recording: PlannedRecording) -> Iterator[PlanProblem]:
    """Ask for one torque, and for no more than one angle: without any there are fallbacks."""
    record = recording.record
    for dimension, least, expected in (
        ("torque", 1, "one channel"),
        ("angle", 0, "at most one channel"),
        ("angular velocity", 0, "at most one channel"),
    ):
        names = channels_of(record, dimension)
        if not least <= len(names) <= 1:
            got = " and ".join(names) or "none"
            message = f"the analysis needs {expected} of {dimension} in each recording, got {got}"
            yield PlanProblem(message=message, key=("channels",), of=recording)
        for name in names:
            symbol = record.units[Member(record.role, name)]
            if symbol != _ANALYSED_IN[dimension]:
                hint = f"the analysis takes a device whose {dimension} is in "
                yield PlanProblem(
                    message=f"the device gives {name} in {symbol}",
                    hint=hint + _ANALYSED_IN[dimension],
                    key=("channels",),
                    of=recording,
                )


def _selection_problems(
    spec: TorqueSettings, planned: PlannedRun, chosen: PlannedRun
) -> Iterator[PlanProblem]:
    """Yield what a `where` chooses that is not there, and labels that would be averaged."""
    places = [recording.coordinates for recording in planned.recordings]
    places += [row.coordinates for row in planned.rows]
    for name, written in spec.where.items():
        value, symbol = in_si(written)
        values = {place[name] for place in places if name in place}
        if not values:
            names = dict.fromkeys(key for place in places for key in place)
            listed = f"counters and labels: {', '.join(names) or 'none'}"
            yield PlanProblem(
                message=f"nothing that is recorded or measured has '{name}'",
                hint=did_you_mean(name, names, listed),
                key=("where", name),
                at_key=True,
            )
        elif not any(matches({name: coordinate}, {name: written}) for coordinate in values):
            texts = ", ".join(sorted(coordinate_text(coordinate, symbol) for coordinate in values))
            message = f"nothing has {name} {coordinate_text(value, symbol)}"
            yield PlanProblem(message=message, hint=f"there are: {texts}", key=("where", name))
    mixed = mixed_labels(
        (recording.record.setpoints, recording.coordinates, recording.coordinate_units)
        for recording in chosen.recordings
    )
    if mixed:
        hint = "say which ones it is of, such as 'where: {phase: final}' in the analysis"
        message = f"recordings with the same set-points would be averaged: {mixed}"
        yield PlanProblem(message=message, hint=hint)


def _instrument_problems(
    planned: PlannedRun, channel: Member, recording: PlannedRecording
) -> Iterator[PlanProblem]:
    channels = [instrument.channel for instrument in planned.instruments]
    part = StationPart.INSTRUMENTS
    if channel not in channels:
        hint = did_you_mean(channel, channels, f"registered: {', '.join(channels) or 'none'}")
        message = f"there is no instrument for the channel {channel}"
        yield PlanProblem(message=message, hint=hint, of=part, at_key=True, needed_by=recording)
        return
    index = channels.index(channel)
    if planned.instruments[index].low_pass is None:
        yield PlanProblem(
            message=f"the low_pass of the instrument for {channel} is missing",
            hint="the filter shapes the torque at the reversals",
            key=(index,),
            of=part,
            needed_by=recording,
        )


def _motion_problems(spec: TorqueSettings, chosen: PlannedRun) -> Iterator[PlanProblem]:
    """Yield every recording without the cyclic motion that the analysis needs."""
    for recording in () if spec.starts is not None else chosen.recordings:
        role = recording.record.role
        if not recording.record.cycle_frequency_hz:
            message = "the analysis needs a cycle frequency, and none is set here"
            hint = "set the drive before"
        elif Member(role, _FREQUENCY) not in recording.record.setpoints:
            message = f"the analysis needs the set frequency of '{role}' itself"
            hint = f"set {role}.frequency, also where another device drives it"
        else:
            continue
        yield PlanProblem(message=message, hint=hint, of=recording, at_key=True)


def _limit_problems(
    spec: TorqueSettings, chosen: PlannedRun, context: AnalysisContext
) -> Iterator[PlanProblem]:
    """Yield each limit of another torque than the planned one, or of one that is not recorded.

    What speaks against it at any load is reported without a plan.
    """
    kind = kind_of(spec, context.plugins)
    loads = _loads(spec, chosen)
    for limit in chosen.limits:
        if limit.of != spec.name or not spec.primary:
            continue
        if isinstance(limit.measurand, LimitMeasurand) and kind is not None:
            objection = limit.measurand.objection(kind, loads)
            if objection and not limit.measurand.objection(kind):
                hint = "a limit applies only to results of the same measurand"
                yield PlanProblem(message=objection, hint=hint, key=("measurand",), of=limit)
        yield from _missing_frequencies(limit, chosen)


def _missing_frequencies(limit: PlannedLimit, chosen: PlannedRun) -> Iterator[PlanProblem]:
    """Yield the named frequencies of a limit at which nothing is recorded."""
    if chosen.rows:
        return
    recorded_hz = {
        value
        for recording in chosen.recordings
        for name, value in recording.record.setpoints.items()
        if unit(recording.record.units[name]).dimension == "frequency"
    }
    recorded = [CoordinateValue(hz, "Hz") for hz in sorted(recorded_hz)]
    places = limit.where.get(_FREQUENCY, ())
    missing = [place for place in places if not any(is_place(place, hz) for hz in recorded)]
    if missing:
        hint = f"recorded: {', '.join(map(str, recorded)) or 'nothing'}"
        message = f"nothing is recorded at {', '.join(map(str, missing))}"
        yield PlanProblem(message=message, hint=hint, key=("where", _FREQUENCY), of=limit)


def _loads(spec: TorqueSettings, chosen: PlannedRun) -> list[float]:
    """Return the set loads of what is judged, as far as the procedure sets them, in N."""
    records = [recording.record for recording in chosen.recordings]
    loads = [record.setpoints.get(Member(record.role, "load")) for record in records]
    set_loads = [load for load in loads if load is not None]
    return [load for load in set_loads if load > 0] if spec.has_own_no_load else set_loads


_FREQUENCY_TOLERANCE = 0.005
"""How far, relatively, a set frequency of the two runs may differ and still be the same one."""


def partner_problems(
    spec: TorqueSettings, planned: PlannedRun, partner: RunData, context: AnalysisContext
) -> Iterator[str]:
    """Yield what speaks against a no-load run: another set-up, or what its recordings lack."""
    transducers = torque_instruments(partner.instruments.values()).values()
    needed_transducers = torque_instruments(planned.instruments)
    rig = planned_rig(planned)
    yield from setup_differences(rig_of(partner), transducers, rig, needed_transducers)
    recordings = sources(partner)
    drive = planned.cycle_drive or ""
    recorded_hz = [recording.setpoints.get(drive, 0.0) for recording in recordings]
    needed_hz = {point.frequency_hz for point in points_of(analysed(planned, spec))}
    missing = [
        hz
        for hz in sorted(needed_hz - {0.0})
        if not any(abs(other - hz) <= _FREQUENCY_TOLERANCE * hz for other in recorded_hz)
    ]
    if missing:
        yield f"it has no recording at {', '.join(f'{hz:g} Hz' for hz in missing)}"
    parts = requirers(spec, context.plugins)
    yield from _unmet(parts, recorded_hz, recordings)
    least = max(part.needs.cycles for part in parts)
    for hz, recording in zip(recorded_hz, recordings, strict=True):
        cycles = (
            int(recording.samples / recording.rate_hz * hz) - 1 if recording.samples > 1 else least
        )
        if cycles < least:
            yield f"its recording {recording.name} has {cycles} cycles, but {least} are needed"


def _unmet(
    parts: Sequence[Requirer], recorded_hz: Sequence[float], recordings: Sequence[Recording]
) -> Iterator[str]:
    """Yield which parts need more frequencies, or the crank phase, than the run has."""
    frequencies = sorted(set(recorded_hz))
    shows_phase = all(
        motion_channel(recording)[0] is not MotionSource.ENTERED for recording in recordings
    )
    for part in parts:
        name, needs = part.name, part.needs
        if len(frequencies) < needs.points:
            got = ", ".join(f"{hz:g} Hz" for hz in frequencies) or "none"
            yield f"{name} needs {needs.points} different frequencies without load, got {got}"
        if needs.phase and not shows_phase:
            yield f"{name} needs the crank phase, and without load nothing shows it"
