"""New places of names of Rigrunner 0.1.0 that are of bearings; `rigrunner.moved` forwards them."""

MOVED = {
    "rigrunner.api.CompensationRecord": "rigrunner_bearings.api:CompensationRecord",
    "rigrunner.api.Influence": "rigrunner_bearings.api:Influence",
    "rigrunner.api.hooks.CompensationRecord": "rigrunner_bearings.api:CompensationRecord",
    "rigrunner.api.hooks.Influence": "rigrunner_bearings.api:Influence",
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
