"""Checks what a compensation returns, before it is used."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING

from rigrunner.api import Estimate
from rigrunner.api.scrutiny import Subject, is_finite, is_real, protect, shown
from rigrunner.signal.propagation import propagate
from rigrunner_bearings.api.compensations import CompensatedPoint, Compensation

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rigrunner_bearings.api.compensations import CompensationMethod, Sweep

UNIT = "N·m"
_ROUNDING = 1e-9
"""How far a torque may be from what its own model gives, of either."""


@dataclass(frozen=True)
class ScrutinisedMethod:
    """A compensation that cannot change its input, and whose output is checked."""

    subject: Subject
    method: CompensationMethod

    def __call__(self, sweep: Sweep) -> Compensation:
        """Return what the method gives; raise PluginError."""
        for prepared in (*sweep.loaded, *sweep.no_load):
            protect(*(getattr(prepared, field.name) for field in fields(prepared)))
        with self.subject.named():
            compensation = self.method(sweep)
        need = self.subject.need
        if not isinstance(compensation, Compensation):
            self.subject.refuse(f"{shown(compensation)}, expected a Compensation")
        if compensation.not_applicable:
            need(not compensation.points, "points, and says that it is not applicable")
            return compensation
        for point in compensation.points:
            # No `need`: it would format the arrays of each point.
            if not isinstance(point, CompensatedPoint):
                self.subject.refuse(f"{shown(point)}, expected a CompensatedPoint")
        frequencies_hz = [point.set_frequency_hz for point in compensation.points]
        expected_hz = [point.set_frequency_hz for point in sweep.loaded]
        self.subject.need(
            frequencies_hz == expected_hz,
            f"points at {_hertz(frequencies_hz)}; expected one for each of {_hertz(expected_hz)}",
        )
        for point in compensation.points:
            self._check(point)
        return replace(compensation, points=tuple(compensation.points))

    def _check(self, point: CompensatedPoint) -> None:
        need, at = self.subject.need, f"at {point.set_frequency_hz:g} Hz"
        torque = point.torque
        need(isinstance(torque, Estimate), f"the torque {shown(torque)} {at}, no Estimate")
        need(torque.unit == UNIT, f"a torque in '{torque.unit}' {at}, expected {UNIT}")
        values = (torque.value, point.raw_nm, point.rig_nm, point.frequency_hz)
        need(all(map(is_finite, values)), f"torque, raw, rig and frequency {shown(values)} {at}")
        u, dof = torque.u, torque.dof
        need(is_real(u) and (math.isnan(u) or 0 <= u < math.inf), f"the uncertainty {u!r} {at}")
        need(is_real(dof) and (math.isnan(dof) or dof > 0), f"{dof!r} degrees of freedom {at}")
        if point.model is not None:
            modelled = propagate(point.model).estimate
            for name in ("value", "u", "dof"):
                value, expected = getattr(torque, name), getattr(modelled, name)
                agrees = math.isclose(value, expected, rel_tol=_ROUNDING, abs_tol=_ROUNDING * u)
                unknown = math.isnan(value) and math.isnan(expected)
                need(
                    agrees or unknown,
                    f"a torque {at} whose {name} is {value:g}, by its own model {expected:g}",
                )


def _hertz(frequencies: Iterable[float]) -> str:
    named = ", ".join(f"{hz:g}" for hz in frequencies)
    return f"{named} Hz" if named else "no frequency"
