"""What a compensation gives, looked at before it is used."""

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
    """A compensation that gets what it cannot change, and gives what can be used."""

    subject: Subject
    method: CompensationMethod

    def __call__(self, sweep: Sweep) -> Compensation:
        """Return what the method gives; raise PluginError."""
        for prepared in (*sweep.loaded, *sweep.no_load):
            protect(*(getattr(prepared, each.name) for each in fields(prepared)))
        with self.subject.named():
            found = self.method(sweep)
        need = self.subject.need
        if not isinstance(found, Compensation):
            self.subject.refuse(f"{shown(found)}, expected a Compensation")
        if found.not_applicable:
            need(not found.points, "points, and says that it is not applicable")
            return found
        for point in found.points:
            if not isinstance(point, CompensatedPoint):  # its arrays are told only where needed
                self.subject.refuse(f"{shown(point)}, expected a CompensatedPoint")
        given = [point.set_frequency_hz for point in found.points]
        due = [point.set_frequency_hz for point in sweep.loaded]
        self.subject.need(
            given == due, f"points at {_hertz(given)}; expected one for each of {_hertz(due)}"
        )
        for point in found.points:
            self._check(point)
        return replace(found, points=tuple(found.points))

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
                given, due = getattr(torque, name), getattr(modelled, name)
                agrees = math.isclose(given, due, rel_tol=_ROUNDING, abs_tol=_ROUNDING * u)
                unknown = math.isnan(given) and math.isnan(due)
                need(
                    agrees or unknown,
                    f"a torque {at} whose {name} is {given:g}, by its own model {due:g}",
                )


def _hertz(frequencies: Iterable[float]) -> str:
    named = ", ".join(f"{each:g}" for each in frequencies)
    return f"{named} Hz" if named else "no frequency"
