"""Properties of the rig that no run shows: from the station, the settings or the literature."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, sqrt
from typing import TYPE_CHECKING

from rigrunner.api import Distribution, Effect, Estimate, Input
from rigrunner.signal.inputs import limited
from rigrunner_bearings.api.torque import DRIFT_LINE, SUPPORT_LINE

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigrunner_bearings.api.compensations import Sweep
    from rigrunner_bearings.api.rig import RigDescription
    from rigrunner_bearings.compensations.settings import InverseSettings, SupportSettings

LITERATURE = 0.025
"""Share of the support's friction that a load of REFERENCE_LOAD_N may add in a rolling bearing.

An assumption, to be replaced by a measurement. Its form is that of Palmgren's friction due to load,
M1 = f1 F dm with f1 = z (F/C0)^y; z = 0.001 and y = 0.33 are assumed for an angular contact ball
bearing, dm = 60 mm and C0 = 30 kN for the spindle. So M1 is 0.020 N·m at 1000 N, 2.6 % of a
support friction of 0.76 N·m.
"""
REFERENCE_LOAD_N = 1000.0
"""A load raises friction and does not lower it: the assumed growth is between zero and LITERATURE.

The best estimate is the middle, with half of the range as half-width (GUM 4.3.7). Below this load
the same growth is assumed, above it one in proportion to the load.
"""

ASSUMED = "assumed, not measured"
PER_KELVIN = 0.02
"""Share by which the support's friction decreases for each kelvin of warming.

An assumption. Rolling friction follows the viscosity to the power of 0.6 (SKF). The viscosity of
a mineral oil decreases by 5 % to 6 % a kelvin at room temperature (ISO VG 68, viscosity index 95,
ASTM D341), so rolling friction by 3.3 %. Sliding friction in mixed lubrication hardly changes; it
is assumed to be 40 % of the whole.
"""
ROOM_K = 4.0
"""Largest difference of two runs, each within 23 °C ± 2 K (ISO 291, class 2); most likely 0."""

SAME_LOAD = 1.02
"""Loads whose readings differ by less, as a ratio, are one nominal load."""


@dataclass(frozen=True)
class SupportGrowth:
    """Growth of the support's friction under load: a share of it, or a measured torque.

    Under the greatest load of a sweep the share is within `growth` ± `limit`. Both are 0 if the
    torque was measured.
    """

    growth: float
    limit: float
    at_points: tuple[float, ...]
    """The growth at each loaded point, over that under the greatest load."""
    source: str = ""
    """Source of the value; '' if station or procedure state the value without a source."""
    measured: Estimate | None = None
    """The torque that the greatest load adds, at the place where the starting torque is read."""

    @property
    def name(self) -> str:
        """The line of the budget, which names the source."""
        return f"{SUPPORT_LINE} ({self.source})" if self.source else SUPPORT_LINE

    @property
    def torques_nm(self) -> tuple[float, ...]:
        """What is subtracted from the result of each point.

        A growth is subtracted from the waveforms.
        """
        torque_nm = 0.0 if self.measured is None else self.measured.value
        return tuple(share * torque_nm for share in self.at_points)

    def effect(self, dry_nm: float, share: float) -> Effect:
        """Return its effect on a result that contains a dry friction of `dry_nm`.

        `share` is that of `at_points`.
        """
        if self.measured is None:
            return Effect(limited(self.name, self.limit, "1", self.growth), -dry_nm * share)
        torque = self.measured
        cause = Input(self.name, torque.value, torque.u, torque.dof, Distribution.T, common=True)
        return Effect(cause, -share)


def settings_of_rig(settings: InverseSettings, rig: RigDescription) -> InverseSettings:
    """Return the settings, with the inertia mismatch of the station if it states one."""
    if rig.inertia_mismatch is None:
        return settings
    return settings.model_copy(update={"inertia_mismatch": rig.inertia_mismatch})


def support_growth(settings: SupportSettings, sweep: Sweep) -> SupportGrowth:
    """Return the growth that the station states, else that of the settings, else the literature.

    A growth stated for another load is scaled in proportion to the load.
    """
    rig, loads_n = sweep.rig, _loads_n(sweep)
    if rig.support_load_dependence is not None:
        stated_n = rig.support_load
        shares = [load_n / stated_n if stated_n and load_n > 0 else 1.0 for load_n in loads_n]
        greatest, at_points = _greatest(shares)
        return SupportGrowth(
            (rig.support_load_growth or 0.0) * greatest,
            rig.support_load_dependence * greatest,
            at_points,
            rig.support_load_source,
        )
    if settings.support_load_dependence is not None:
        growth, at_points = settings.support_load_growth or 0.0, (1.0,) * len(loads_n)
        return SupportGrowth(growth, settings.support_load_dependence, at_points)
    greatest, at_points = _greatest([max(1.0, load_n / REFERENCE_LOAD_N) for load_n in loads_n])
    half = LITERATURE * greatest / 2
    return SupportGrowth(half, half, at_points, ASSUMED)


def states_support(settings: SupportSettings, rig: RigDescription) -> bool:
    """Return whether station or procedure state how the support's friction changes under load."""
    stated = (rig.support_under_load, rig.support_load_dependence, settings.support_load_dependence)
    return any(value is not None for value in stated)


def support_drift(settings: SupportSettings, sweep: Sweep) -> Input | None:
    """Return the relative change of the support's dry friction between two runs.

    The station may state its limit. If station or procedure state the friction under load, their
    limit includes all that changes between the runs. None if nothing is to be added, also if no
    time passes between the runs, or if a second no-load run shows the change.
    """
    rig, limit = sweep.rig, sweep.rig.support_drift
    if not sweep.apart or limit == 0:
        return None
    if limit is not None:
        return limited(DRIFT_LINE, limit, "1")
    if states_support(settings, rig):
        return None
    u = PER_KELVIN * ROOM_K / sqrt(6)
    name = f"{DRIFT_LINE} ({ASSUMED})"
    return Input(name, 0.0, u, inf, Distribution.TRIANGULAR, "1", common=True)


def support_under_load(settings: SupportSettings, sweep: Sweep) -> SupportGrowth:
    """Return the growth for a starting torque: a measured one, if the station states it."""
    measured = sweep.rig.support_under_load
    if measured is None:
        return support_growth(settings, sweep)
    share, at_points = _greatest([load_n / measured.load for load_n in _loads_n(sweep)])
    dof = inf if measured.degrees_of_freedom is None else measured.degrees_of_freedom
    torque = Estimate(measured.torque * share, measured.u * share, dof)
    return SupportGrowth(0.0, 0.0, at_points, measured.source, torque)


def _loads_n(sweep: Sweep) -> list[float]:
    """Return the load of each loaded point; points under one nominal load have the same."""
    loads_n = [point.load_n for point in sweep.loaded]
    # `own` beside them: a negative reading, about zero, is above that bound.
    return [max([own, *(n for n in loads_n if n <= SAME_LOAD * own)]) for own in loads_n]


def _greatest(shares: Sequence[float]) -> tuple[float, tuple[float, ...]]:
    """Return the greatest share, and each as a fraction of it."""
    greatest = max(shares, default=1.0)
    return greatest, tuple(share / greatest if greatest > 0 else 1.0 for share in shares)


def load(rig: RigDescription) -> Input:
    """Return the relative error of the load: friction is proportional to it (Coulomb)."""
    return limited("load", rig.load_tolerance, "1")
