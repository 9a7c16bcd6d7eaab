"""The compensation old_compensation: raw peak minus no-load peak.

The two peaks do not stand at the same phase of the swing, so that the difference drifts with
frequency: put a better method in its place. `rigrunner.signal` has what it may be made of.
"""

from rigrunner.api.analysis import (
    CompensatedPoint,
    Compensation,
    CompensationMethod,
    PeakPoint,
    Sweep,
)
from rigrunner.api.errors import DataError
from rigrunner.api.hooks import CompensationRecord, NoSettings, hookimpl
from rigrunner.api.measurand import Condition, MeasurandKind, Nature
from rigrunner.api.uncertainty import Distribution, Effect, Input
from rigrunner.signal.inputs import limited, model_of
from rigrunner.signal.peaks import mean_peak, scatter_effect
from rigrunner.signal.propagation import compensated_point
from rigrunner.signal.sensor import difference_effects, gain

api_version = 1
NEAR = 0.05
"""How far apart two frequencies may be, as a part of the loaded one."""


def compensate(sweep: Sweep) -> Compensation:
    """Return the difference per set-point; DataError for one without a no-load partner."""
    points = tuple(_point(sweep, loaded) for loaded in sweep.loaded)
    return Compensation("starting torque as the difference of raw peaks", points)


def _point(sweep: Sweep, loaded: PeakPoint) -> CompensatedPoint:
    no_load = _partner(loaded, sweep)
    raw, rig = mean_peak(loaded), mean_peak(no_load)
    effects = (
        scatter_effect("scatter between cycles, loaded", raw),
        scatter_effect("scatter between cycles, no load", rig),
        _frequency(loaded, no_load, rig.value),
        *difference_effects(sweep.instrument, runs=2),
    )
    scales = (gain(sweep.instrument), limited("load", sweep.rig.load_tolerance, "1"))
    return compensated_point(
        model_of(raw.value - rig.value, effects, scales=scales),
        set_frequency_hz=loaded.set_frequency_hz,
        frequency_hz=loaded.frequency_hz.value,
        raw_nm=raw.value,
    )


def _partner(loaded: PeakPoint, sweep: Sweep) -> PeakPoint:
    hertz = loaded.frequency_hz.value
    near = [p for p in sweep.no_load if abs(p.frequency_hz.value - hertz) <= NEAR * hertz]
    if not near:
        raise DataError(
            f"no no-load recording within {NEAR:.0%} of {hertz:.4g} Hz ({loaded.recording})",
            hint="record the no-load sweep at the same frequencies",
        )
    return min(near, key=lambda point: abs(point.frequency_hz.value - hertz))


def _frequency(loaded: PeakPoint, no_load: PeakPoint, rig_nm: float) -> Effect:
    """Return what the peak may differ by because the two frequencies are not known to be one.

    Of inertia alone the no-load peak goes with the square of frequency: its slope is 2 T/f.
    """
    one, other = loaded.frequency_hz, no_load.frequency_hz
    u = (one.u**2 + other.u**2 + (one.value - other.value) ** 2 / 3) ** 0.5
    dof = min(one.dof, other.dof)
    apart = Input("frequency", 0.0, u, dof, Distribution.T, "Hz")
    return Effect(apart, -2 * rig_nm / other.value)


def _make(_: NoSettings) -> CompensationMethod:
    return compensate


@hookimpl
def rigrunner_compensations() -> list[CompensationRecord]:
    """Tell Rigrunner what is in this file."""
    return [
        CompensationRecord(
            name="old_compensation",
            help="Old compensation: raw peak minus no-load peak",
            factory=_make,
            yields=MeasurandKind(Nature.LOAD_INDUCED, Condition.AT_REVERSAL),
            not_covered="the two peaks stand at different phases of the swing",
        )
    ]
