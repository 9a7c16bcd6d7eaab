"""What a recording shows of its motion: cycles and frequency, and the phase if anything shows it.

The angle channel shows all. The swing's angular velocity or one index pulse in every cycle show
frequency and phase too, the phase with a doubt of its own. Without any of them cycles are cut by
the entered frequency, and there is no phase.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from math import hypot, inf, pi, sqrt
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api import DataError, Estimate
from rigrunner.api.analysis.requirements import LEAST_CYCLES
from rigrunner_bearings.api.points import MotionSource
from rigrunner_bearings.api.rig import rig_of
from rigrunner_bearings.signal.cycles import find_cycles, integrated_swing
from rigrunner_bearings.signal.kinematics import swing_angle
from rigrunner_bearings.signal.pulses import pulse_edges, starts_by_frequency, starts_from_edges
from rigrunner_bearings.torque.channels import finite, motion_channel, set_frequency, torque_channel
from rigrunner_bearings.torque.waveforms import PHASES, mean_of

if TYPE_CHECKING:
    from collections.abc import Callable

    from rigrunner.api import Array, Mask, Recording, RunData
    from rigrunner.api.data import Samples
    from rigrunner_bearings.api.rig import RigDescription

ENTERED_LIMIT = 0.005
"""Of an entered frequency: half-width of what it may be off; an angle channel flags more."""

HALF_SAMPLE = 0.5 / sqrt(3)
"""Standard uncertainty of an edge between two samples, in samples (GUM 4.3.7)."""


@dataclass(frozen=True, eq=False)
class Motion:
    """The whole cycles of a recording.

    `starts` are fractional sample indices, shape (cycles + 1,). `mean_angle` gives the swing angle
    in rad on PHASES crank phases, shape (PHASES,): the mean of the cycles that a mask (cycles,)
    keeps. It is None where nothing shows the phase.
    """

    source: MotionSource
    starts: Array
    frequency_hz: Estimate
    mean_angle: Callable[[Mask], Array] | None = None
    phase_u_rad: float = 0.0
    """Of the crank phase, in this recording alone."""
    phase_common_u_rad: float = 0.0
    """Of the crank phase, the same in all recordings of the rig."""
    channel: str = ""
    """The channel that shows it; empty where nothing does."""


def find_motion(recording: Recording, run: RunData, torque_nm: Samples) -> Motion:
    """Return the motion by the best that was recorded; `torque_nm` (n,) is cut where nothing was.

    Raises DataError naming recording and channel.
    """
    source, name = motion_channel(recording)
    where = f"recording {recording.name}, {name or torque_channel(recording, run.instruments)}"
    try:
        return replace(_motion(source, name, recording, run, torque_nm), channel=name)
    except DataError as error:
        raise DataError(f"{where}: {error.message}", hint=error.hint) from error


def _motion(
    source: MotionSource, name: str, recording: Recording, run: RunData, torque_nm: Samples
) -> Motion:
    rate_hz = recording.rate_hz
    if source is MotionSource.ENTERED:
        torque = torque_channel(recording, run.instruments)
        entered_hz = set_frequency(recording, torque)
        starts = starts_by_frequency(torque_nm, rate_hz, entered_hz)
        _refuse_few(starts)
        return Motion(MotionSource.ENTERED, starts, entered_frequency(entered_hz))
    values = finite(recording, name)
    if source is MotionSource.INDEX:
        return _by_index(values, rate_hz, rig_of(run))
    return _by_angle(source, values, rate_hz, rig_of(run))


def _by_angle(source: MotionSource, values: Samples, rate_hz: float, rig: RigDescription) -> Motion:
    """Return the motion that an angle, or the angular velocity, shows."""
    if source is MotionSource.TACHO:
        values = integrated_swing(np.asarray(values), rate_hz, rig.eccentric_ratio)
    cycles = find_cycles(values, rate_hz, rig.eccentric_ratio)
    _refuse_few(cycles.starts)
    return Motion(
        source=source,
        starts=cycles.starts,
        frequency_hz=_frequency(cycles.starts, rate_hz),
        mean_angle=partial(mean_of, values, cycles.starts, cycles.offset_rad),
        phase_common_u_rad=_tolerance(rig) if source is MotionSource.TACHO else 0.0,
    )


def _by_index(pulses: Samples, rate_hz: float, rig: RigDescription) -> Motion:
    edges = pulse_edges(pulses)
    starts = starts_from_edges(edges, rig.index_phase, len(pulses))
    _refuse_few(starts)
    frequency = _frequency(starts, rate_hz, edge_u=HALF_SAMPLE)
    return Motion(
        source=MotionSource.INDEX,
        starts=starts,
        frequency_hz=frequency,
        mean_angle=partial(_kinematic_angle, rig.eccentric_ratio),
        phase_u_rad=2 * pi * frequency.value / rate_hz * _edge_u(edges),
        phase_common_u_rad=_tolerance(rig),
    )


def _kinematic_angle(ratio: float, kept: Mask) -> Array:  # noqa: ARG001  (it is that of each)
    return swing_angle(2 * np.pi * np.arange(PHASES) / PHASES, ratio)


def _edge_u(edges: Array) -> float:
    """Return the standard uncertainty of where the mean cycle's pulse rises, in samples.

    Each rise is known to half a sample. What of that shows as scatter about an even turning
    averages out over the cycles; what does not show, as with a whole number of samples in a cycle,
    is the same in all of them.
    """
    turns = np.arange(len(edges))
    residual = edges - np.polyval(np.polyfit(turns, edges, 1), turns)
    visible = float(residual @ residual) / (len(edges) - 2)
    return sqrt(max(HALF_SAMPLE**2 - visible, 0.0) + visible / len(edges))


def entered_frequency(entered_hz: float) -> Estimate:
    """Return an entered frequency that nothing has measured, with its uncertainty."""
    return Estimate(entered_hz, ENTERED_LIMIT * entered_hz / sqrt(3), inf, "Hz")


def _refuse_few(starts: Array) -> None:
    count = max(len(starts) - 1, 0)
    if count < LEAST_CYCLES:
        raise DataError(
            f"{count} whole cycles, but {LEAST_CYCLES} are needed", hint="record more cycles"
        )


def _tolerance(rig: RigDescription) -> float:
    return rig.phase_tolerance / sqrt(3)


def _frequency(starts: Array, rate_hz: float, edge_u: float = 0.0) -> Estimate:
    """Return the mean frequency over all cycles, with the scatter between them as type A.

    `edge_u` is the standard uncertainty of where a cycle starts, in samples; two edges make it.
    """
    count, length = len(starts) - 1, starts[-1] - starts[0]
    mean = float(rate_hz * count / length)
    scatter = (rate_hz / np.diff(starts)).std(ddof=1) / sqrt(count)
    return Estimate(mean, hypot(scatter, mean * sqrt(2) * edge_u / length), count - 1.0, "Hz")
