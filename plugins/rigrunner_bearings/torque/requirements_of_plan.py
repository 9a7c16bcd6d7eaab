"""What the parts of an analysis of torque require, held against the recordings of a plan."""

from __future__ import annotations

from math import pi
from typing import TYPE_CHECKING

from rigrunner.api import Member
from rigrunner.api.analysis.requirements import SPARE_CYCLES
from rigrunner.api.planned import PlanProblem
from rigrunner_bearings.api.requirements import LEAST_REST_S, LEAST_SAMPLES_PER_CYCLE
from rigrunner_bearings.torque.channels import place_of_start
from rigrunner_bearings.torque.requirers import channels_of, motion_channels, points_of, rows_of

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    from rigrunner.api.planned import PlannedRecording, PlannedRun
    from rigrunner_bearings.api.requirements import TorqueRequirements
    from rigrunner_bearings.torque.requirers import Point, Requirer
    from rigrunner_bearings.torque.settings import TorqueSettings

_ROUNDING = 1e-9


def unmet_requirements(
    spec: TorqueSettings, chosen: PlannedRun, parts: Sequence[Requirer]
) -> Iterator[PlanProblem]:
    """Yield all that parts of the analysis need and the run would not give."""
    yield from _kind(spec, parts)
    if not chosen.recordings:
        yield from _tables(spec, chosen, parts)
    elif spec.starts is not None:
        yield from _starts(chosen, parts, spec.starts.window)
    else:
        for recording in chosen.recordings:
            yield from _load(recording)
            yield from _cycles(recording, parts)
            yield from _rate(recording)
            yield from _phase(recording, parts)
        yield from _own_no_load(spec, points_of(chosen), parts)


def _kind(spec: TorqueSettings, parts: Iterable[Requirer]) -> Iterator[PlanProblem]:
    for part in parts:
        if part.needs.fit and not spec.fits:
            message = f"{part.name} takes the first fit, and the procedure names none"
            hint = "add one to the analysis, such as 'fits: [polynomial]'"
            yield PlanProblem(message=message, hint=hint, key=part.key)
        if part.needs.starts is True and spec.starts is None:
            message = f"{part.name} needs starts from rest, and these are swings"
            hint = "write 'breakaway' in the place of 'swing_torque' if they are starts"
            yield PlanProblem(message=message, hint=hint, key=part.key)
        if part.needs.starts is False and spec.starts is not None:
            message = f"{part.name} needs swings, and these are starts from rest"
            hint = "choose a compensation for starts, such as breakaway_peak"
            yield PlanProblem(message=message, hint=hint, key=part.key)


def _cycles(recording: PlannedRecording, parts: Iterable[Requirer]) -> Iterator[PlanProblem]:
    """Ask for enough whole cycles: a recording is of one period more than it has whole ones."""
    record = recording.record
    frequency_hz = record.cycle_frequency_hz or 0.0
    cycles = int(record.duration_s * frequency_hz + _ROUNDING) - 1
    most = max(parts, key=lambda part: part.needs.cycles)
    least = most.needs.cycles + SPARE_CYCLES
    if cycles >= least:
        return
    got = str(cycles) if recording.in_cycles else f"{max(cycles, 0)} at {frequency_hz:g} Hz"
    yield PlanProblem(
        message=f"{most.name} needs at least {least} cycles in each recording, got {got}",
        hint=f"{most.needs.cycles} whole cycles and one more are needed",
        key=("cycles" if recording.in_cycles else "duration",),
        of=recording,
    )


def _rate(recording: PlannedRecording) -> Iterator[PlanProblem]:
    rate_hz, frequency_hz = recording.record.sample_rate_hz, recording.record.cycle_frequency_hz
    if rate_hz is None or not frequency_hz or rate_hz >= LEAST_SAMPLES_PER_CYCLE * frequency_hz:
        return
    message = (
        f"the analysis needs at least {LEAST_SAMPLES_PER_CYCLE} samples in a cycle, "
        f"got {rate_hz / frequency_hz:.3g}: {rate_hz:g} Hz at {frequency_hz:g} Hz"
    )
    hint = "sample faster, or swing more slowly"
    yield PlanProblem(message=message, hint=hint, of=recording, at_key=True)


def _phase(recording: PlannedRecording, parts: Iterable[Requirer]) -> Iterator[PlanProblem]:
    if motion_channels(recording.record):
        return
    for part in parts:
        if part.needs.phase:
            message = f"{part.name} needs the crank phase, and no recorded channel shows it"
            hint = f"record an angle, such as {recording.record.role}.angle"
            yield PlanProblem(message=message, hint=hint, key=("channels",), of=recording)


def _load(recording: PlannedRecording) -> Iterator[PlanProblem]:
    """Ask for a known load: each point of a result is one under a load."""
    member = Member(recording.record.role, "load")
    if member not in recording.record.setpoints and member not in recording.conditions:
        message = f"the analysis needs the load, and {member} is neither set nor read"
        hint = f"set it before, such as 'set: {{{member}: 0 N}}'"
        yield PlanProblem(message=message, hint=hint, of=recording, at_key=True)


def _starts(
    chosen: PlannedRun, parts: Sequence[Requirer], window_rad: float
) -> Iterator[PlanProblem]:
    groups: dict[tuple[float, float], list[PlannedRecording]] = {}
    for recording in chosen.recordings:
        speed_hz, load_n = place_of_start(recording.record.setpoints, recording.record.role)
        groups.setdefault((speed_hz, load_n), []).append(recording)
        yield from _travel(recording, speed_hz, window_rad)
    most = max(parts, key=lambda part: part.needs.cycles)
    for (speed_hz, load_n), group in groups.items():
        if len(group) < most.needs.cycles:
            message = (
                f"{most.name} needs at least {most.needs.cycles} starts at each speed and load, "
                f"got {len(group)} at {speed_hz:g} Hz and {load_n:g} N"
            )
            hint = "repeat the recording"
            yield PlanProblem(message=message, hint=hint, of=group[0], at_key=True)


def _travel(
    recording: PlannedRecording, speed_hz: float, window_rad: float
) -> Iterator[PlanProblem]:
    """Ask for an angle, and for time enough to rest and to turn through the window."""
    record = recording.record
    if not channels_of(record, "angle"):
        message = "a start from rest needs an angle, and none is recorded"
        hint = f"record the angle of rotation, such as {record.role}.angle"
        yield PlanProblem(message=message, hint=hint, key=("channels",), of=recording)
    if not speed_hz > 0:
        message = "the analysis needs a start, and no speed is set here"
        yield PlanProblem(message=message, hint="set the drive before", of=recording, at_key=True)
        return
    least_s = LEAST_REST_S + window_rad / (2 * pi * speed_hz)
    if record.duration_s <= least_s:
        message = (
            f"a start at {speed_hz:g} Hz needs more than {least_s:.3g} s, "
            f"got {record.duration_s:.3g} s"
        )
        hint = f"{LEAST_REST_S:g} s of rest, and the time to turn through the window"
        yield PlanProblem(message=message, hint=hint, key=("duration",), of=recording)


def _own_no_load(
    spec: TorqueSettings, points: Sequence[Point], parts: Sequence[Requirer]
) -> Iterator[PlanProblem]:
    """Ask of a run that is its own no-load run for both kinds of set-points, at fitting places."""
    if not spec.has_own_no_load:
        return
    loaded = [point for point in points if point.loaded]
    no_load = [point for point in points if not point.loaded]
    for kind, kind_points in (("with", loaded), ("without", no_load)):
        if not kind_points:
            message = f"the run is to be its own no-load run, and has no set-point {kind} load"
            hint = "set the load to 0 N for one part of the run"
            yield PlanProblem(message=message, hint=hint, key=("no_load",))
    if not (loaded and no_load):
        return
    yield from _without_load(parts, no_load)
    for part in parts:
        missing = _unmatched(part.needs, loaded, no_load)
        if missing:
            hint = f"without load: {', '.join(f'{p.frequency_hz:g} Hz' for p in no_load)}"
            message = f"{part.name} needs set-points without load for {missing}"
            yield PlanProblem(message=message, hint=hint, key=part.key)


def _without_load(parts: Iterable[Requirer], no_load: Sequence[Point]) -> Iterator[PlanProblem]:
    """Yield who needs more than the set-points without load give, and a way out."""
    frequencies = sorted({point.frequency_hz for point in no_load})
    for part in parts:
        least = part.needs.points
        if len(frequencies) < least:
            got = ", ".join(f"{hz:g} Hz" for hz in frequencies) or "none"
            message = f"{part.name} needs {least} different frequencies without load, got {got}"
            hint = "record without load at more frequencies"
            yield PlanProblem(message=message, hint=hint, key=part.key)
        if part.needs.phase and not all(point.shows_phase for point in no_load):
            message = f"{part.name} needs the crank phase, and without load nothing shows it"
            hint = "record the angle without load, such as tester.angle"
            yield PlanProblem(message=message, hint=hint, key=part.key)


def _unmatched(needs: TorqueRequirements, loaded: Iterable[Point], no_load: Iterable[Point]) -> str:
    """Return the loaded frequencies for which those without load do not do; '' for none."""
    no_load_hz = [point.frequency_hz for point in no_load]
    missing = [
        hz
        for hz in dict.fromkeys(point.frequency_hz for point in loaded)
        if (
            needs.frequency_match is not None
            and not any(abs(other - hz) <= needs.frequency_match * hz for other in no_load_hz)
        )
        or (needs.within_no_load_range and not min(no_load_hz) <= hz <= max(no_load_hz))
    ]
    return ", ".join(f"{hz:g} Hz" for hz in missing)


def _tables(
    spec: TorqueSettings, chosen: PlannedRun, parts: Sequence[Requirer]
) -> Iterator[PlanProblem]:
    """Ask of a run without recordings for a torque that is measured in motion, and a load."""
    points = list(rows_of(chosen))
    if not points:
        message = "the analysis needs a recording, or a torque that is measured in motion"
        hint = "add a record step, or set the frequency before the torque is measured"
        yield PlanProblem(message=message, hint=hint)
        return
    if spec.starts is not None:
        message = "starts from rest need recordings, and only single values are measured"
        yield PlanProblem(message=message, hint="add a record step")
    for part in parts:
        if part.needs.phase:
            message = f"{part.name} needs recorded swings, and only single values are measured"
            hint = "record the angle and the torque"
            yield PlanProblem(message=message, hint=hint, key=part.key)
    yield from _own_no_load(spec, points, parts)
