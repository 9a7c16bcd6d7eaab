"""Forty simulated rigs, each with none, one or two faults, as station files.

The draws are of `random.Random`, whose sequence Python promises to keep.
"""

from __future__ import annotations

import json
import random

SEEDS = range(40)
_ODE_EVERY = 4

_STATION = """\
rigrunner: station/1
id: guard-{seed}
title: Rig {seed} of the guard
rig:
  mandrel: M-01
  eccentric: 2 mm
  centre_distance: 45 mm
  inertia: 0.00233 kg·m²
  support_friction: 0.76 N·m
  support_damping: 0.31 N·m·s/rad
  swing_radius: 10.4 mm
  support_drift: 0 %
devices:
  tester: {{type: swing_tester, plugin: {plugin}, settings: {settings}}}
instruments:
  - channel: tester.torque
    type: simulated torque transducer
    serial: SIM-{seed}
    calibration: simulated
    full_scale: 10 N·m
    accuracy: {{gain: 0.3 %, offset: 0.02 N·m, drift: 0.02 N·m, nonlinearity: 0.05 %}}
    low_pass: {{type: butterworth, order: 2, corner: 1 kHz}}
"""

_COMMON_FAULTS = (
    ("", "frequency_error", 0.2, 3.0, "%"),
    ("", "speed_jitter", 0.05, 0.5, "%"),
    ("sensors", "range", 4.0, 6.5, "N·m"),  # clips
    ("sensors", "spike_probability", 0.02, 0.3, "%"),
    ("sensors", "noise", 0.05, 0.2, "N·m"),
    ("sensors", "low_pass", 300, 800, "Hz"),  # not that of the register
    ("sensors", "torque_delay", 0.05, 0.4, "ms"),
    ("sensors", "encoder_noise", 0.003, 0.02, "deg"),
    ("sensors", "drift", 0.05, 0.2, "N·m"),
)
_CLOSED_FORM_FAULTS = (
    ("drive_line", "inertia_change_under_load", 0.3, 8.0, "%"),
    ("support", "growth_per_kilonewton", 1.0, 10.0, "%"),
    ("bearing", "zero_load_torque", 0.02, 0.2, "N·m"),
    ("bearing", "asymmetry", 0.02, 0.2, "N·m"),
)


def station(seed: int) -> str:
    """Return the station file of one rig."""
    draw = random.Random(seed)  # noqa: S311  (the draw must be repeatable)
    is_ode = seed % _ODE_EVERY == _ODE_EVERY - 1
    faults = _COMMON_FAULTS if is_ode else _COMMON_FAULTS + _CLOSED_FORM_FAULTS
    settings: dict[str, object] = {"seed": seed}
    shaft = "shaft" if is_ode else "drive_line"
    settings[shaft] = {"natural_frequency": f"{draw.uniform(250, 600):.1f} Hz"}
    for group, name, low, high, unit in draw.sample(faults, draw.choice((0, 1, 1, 2))):
        place = settings.setdefault(group, {}) if group else settings
        place[name] = f"{draw.uniform(low, high):.4g} {unit}"
    plugin = "swing_tester_ode" if is_ode else "swing_tester_sim"
    text = json.dumps(settings, ensure_ascii=False)  # which is YAML too
    return _STATION.format(seed=seed, plugin=plugin, settings=text)
