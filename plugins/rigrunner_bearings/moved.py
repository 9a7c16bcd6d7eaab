"""New places of names of Rigrunner 0.1.0 that are of bearings; `rigrunner.moved` forwards them."""

from collections.abc import Mapping

_API = "rigrunner_bearings.api"
_OF_THE_ANALYSIS = {
    "compensations": "CompensatedPoint Compensation CompensationMethod Sweep SwingSweep Trace",
    "points": "MotionSource PeakPoint StartPoint SwingPoint",
}
"""Names of `rigrunner.api.analysis` by their module in `rigrunner_bearings.api`."""
_OF_THE_API = {
    "compensations": "CompensatedPoint Compensation CompensationMethod Sweep",
    "points": "PeakPoint SwingPoint",
    "measurand": "Condition MeasurandKind Nature",
    "rig": "RigDescription",
    "torque": "TorqueDetails",
}
"""Names of `rigrunner.api` in the same way."""


def _moved(old: str, tables: Mapping[str, str]) -> dict[str, str]:
    return {
        f"{old}.{name}": f"{_API}.{module}:{name}"
        for module, names in tables.items()
        for name in names.split()
    }


MOVED = {
    **_moved("rigrunner.api.analysis", _OF_THE_ANALYSIS),
    **_moved("rigrunner.api", _OF_THE_API),
    "rigrunner.api.CompensationRecord": f"{_API}:CompensationRecord",
    "rigrunner.api.Influence": f"{_API}:Influence",
    "rigrunner.api.hooks.CompensationRecord": f"{_API}:CompensationRecord",
    "rigrunner.api.hooks.Influence": f"{_API}:Influence",
    "rigrunner.api.data.RunData.rig": f"{_API}.rig:rig_of",
    "rigrunner.api.gauge": f"{_API}.rig",
    "rigrunner.api.instruments.torque_instruments": f"{_API}.rig:torque_instruments",
    "rigrunner.api.measurand": f"{_API}.measurand",
    "rigrunner.api.results.Result.compensations": f"{_API}.torque:compensations_of",
    "rigrunner.api.rig": f"{_API}.rig",
    "rigrunner.api.torque": f"{_API}.torque",
    "rigrunner.api.validation": f"{_API}.validation",
    "rigrunner.api.verdict.LimitDecision.load_n": f"{_API}.measurand:load_of",
    "rigrunner.signal.cycles": "rigrunner_bearings.signal.cycles",
    "rigrunner.signal.half_turns": "rigrunner_bearings.signal.half_turns",
    "rigrunner.signal.kinematics": "rigrunner_bearings.signal.kinematics",
    "rigrunner.signal.mean_model": "rigrunner_bearings.signal.mean_model",
    "rigrunner.signal.peaks": "rigrunner_bearings.signal.peaks",
    "rigrunner.signal.pulses": "rigrunner_bearings.signal.pulses",
    "rigrunner.signal.propagation.compensated_point": (
        "rigrunner_bearings.signal.compensated:compensated_point"
    ),
    "rigrunner.signal.sensor": "rigrunner_bearings.signal.sensor",
    "rigrunner.signal.starts": "rigrunner_bearings.signal.starts",
    "rigrunner.signal.swings": "rigrunner_bearings.signal.swings",
}
