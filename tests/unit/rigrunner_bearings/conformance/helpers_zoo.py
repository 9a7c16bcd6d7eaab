"""Compensations that are broken in one way each, one for each check of the kit."""

from __future__ import annotations

from dataclasses import replace

from rigrunner.api.accuracy import Accuracy
from rigrunner.api.analysis import Component
from rigrunner.api.data import Estimate
from rigrunner.registry import Plugin, Provider, Registry, load_registry
from rigrunner_bearings.api import CompensationRecord
from rigrunner_bearings.api.compensations import CompensatedPoint, Compensation
from rigrunner_bearings.api.measurand import Condition, MeasurandKind, Nature
from rigrunner_bearings.api.points import MotionSource

SHIPPED = load_registry()
STARTING = MeasurandKind(Nature.LOAD_INDUCED, Condition.AT_REVERSAL)


def peaks(sweep):
    return SHIPPED.make("compensation", "peak_same_frequency", {})(sweep)


def shifted(by):
    """Return a method that shifts each torque by `by(place, sweep)`."""

    def method(sweep):
        compensation = peaks(sweep)
        points = [
            replace(
                point,
                torque=replace(point.torque, value=point.torque.value + by(place, sweep)),
                rig_nm=point.rig_nm - by(place, sweep),
                model=None,
            )
            for place, point in enumerate(compensation.points)
        ]
        return replace(compensation, points=tuple(points))

    return method


class Unrepeatable:
    calls = 0

    def __call__(self, sweep):
        self.calls += 1
        return shifted(lambda *_: 1e-6 * self.calls)(sweep)


def parts_do_not_add_up(sweep):
    compensation = peaks(sweep)
    return replace(
        compensation, points=tuple(replace(p, rig_nm=p.rig_nm + 0.1) for p in compensation.points)
    )


def u_not_from_parts(sweep):
    compensation = peaks(sweep)
    points = [replace(p, torque=replace(p.torque, u=2 * p.torque.u)) for p in compensation.points]
    return replace(compensation, points=tuple(points))


def ignores_sensor(sweep):
    fixed = Accuracy.model_validate({"gain": "0.3 %", "drift": "0.02 N·m"}).limits
    accuracy = sweep.instrument.accuracy.model_copy(update=fixed)
    instrument = sweep.instrument.model_copy(update={"accuracy_": accuracy})
    return peaks(replace(sweep, instrument=instrument))


def ignores_transducer_errors(sweep):
    limits = {
        name: limit for name, limit in sweep.instrument.accuracy_ if name in ("gain", "drift")
    }
    instrument = sweep.instrument.model_copy(update={"accuracy_": Accuracy.model_validate(limits)})
    return peaks(replace(sweep, instrument=instrument))


def needs_no_reference(sweep):
    return peaks(sweep) if sweep.no_load else peaks(replace(sweep, no_load=sweep.loaded))


def more_certain_without_angle(sweep):
    compensation = peaks(sweep)
    if sweep.loaded[0].motion is not MotionSource.ENTERED:
        return compensation
    points = [replace(p, torque=replace(p.torque, u=1e-6), model=None) for p in compensation.points]
    return replace(compensation, points=tuple(points))


def treats_starts_as_swings(sweep):
    part = Component("all", 0.1, 10.0, "normal", common=True)
    point = CompensatedPoint(1.0, 1.0, 1.0, 0.0, Estimate(1.0, 0.1, 10.0), (part,))
    return peaks(sweep) if sweep.no_load else Compensation("torque", (point,))


COMPENSATIONS = {
    "can_be_made": {"method": None},
    "measurand_stated": {"yields": None},
    "points_are_whole": {"method": parts_do_not_add_up},
    "uncertainty_is_made_of_its_parts": {"method": u_not_from_parts},
    "sensor_is_in_the_budget": {"method": ignores_sensor},
    "transducer_errors_are_in_the_budget": {"method": ignores_transducer_errors},
    "same_recordings_same_numbers": {"method": Unrepeatable()},
    "truth_is_within_its_interval": {"method": shifted(lambda *_: 1.0)},
    "truth_is_within_it_on_another_rig": {"method": shifted(lambda *_: 1.0)},
    "time_shift_does_not_matter": {
        "method": shifted(lambda _, s: sum(point.cycles for point in s.loaded))
    },
    "sample_rate_does_not_matter": {
        "method": shifted(lambda i, s: 1e-4 * s.loaded[i].sample_rate_hz)
    },
    "common_offset_falls_out": {"method": shifted(lambda i, s: 0.5 * s.no_load[i].peak_nm.mean())},
    "order_of_recordings_does_not_matter": {"method": shifted(lambda place, _: 0.1 * place)},
    "without_no_load_run_it_refuses": {"method": needs_no_reference},
    "without_angle_it_refuses_or_doubts": {"method": more_certain_without_angle},
    "other_motion_is_refused": {"method": treats_starts_as_swings},
}
"""By check: the method that fails it, or the changed fields of its record."""


def compensation_registry(method=peaks, yields=STARTING):
    record = CompensationRecord(
        name="method", help="A method.", factory=lambda _: method, yields=yields
    )
    kinds = [plugin for plugin in SHIPPED.plugins if plugin.kind == "kind"]
    return Registry([Plugin("compensation", record, Provider("zoo", "1")), *kinds])
