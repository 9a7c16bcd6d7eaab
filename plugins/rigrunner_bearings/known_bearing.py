"""What the load adds to the support's friction, by a run with a bearing of known friction.

    T_support = T - T_known

T is between the load-induced starting torque of the run and its running torque; of both nothing was
taken out for the support.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf, isfinite, sqrt
from typing import TYPE_CHECKING

from rigrunner.analysis.analyse import analyse
from rigrunner.api import Component, DataError, Estimate, parse_quantity
from rigrunner.api.analysis import Consequence
from rigrunner.api.checks import forbidden
from rigrunner.procedure import parse_procedure
from rigrunner.run.stored import open_run
from rigrunner.signal.coverage import expanded
from rigrunner.signal.uncertainty import combine
from rigrunner_bearings.api.torque import SUPPORT_LINE, TorqueDetails
from rigrunner_bearings.torque.headline import compensated_mean

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from rigrunner.api import Check, RunData
    from rigrunner.api.results import Result
    from rigrunner.registry import Registry

KNOWN_FRICTION, KNOWN_LIMIT = "known_friction", "known_limit"
"""The inputs of the procedure with the bearing's friction and its limit of error."""
MOST = 0.25
"""Of the support's friction. No rolling bearing adds as much: another bearing is mounted."""
RUNNING = "energy"
"""The compensation that gives the running torque; runs of earlier procedures have none."""
SLIP = "way over which the support's friction builds up"
SIGNIFICANT = 2.0
"""Standard uncertainties of a bias."""
MOST_DOF = 1000.0
"""More degrees of freedom make no difference."""
_STATED = ("support_under_load", "support_load_growth", "support_load_dependence", "support_load")


@dataclass(frozen=True)
class SupportFriction:
    """What a run found of the support."""

    run_id: str
    torque: Estimate
    """That the load adds where the starting torque is read, in N·m."""
    growth: Estimate
    """The same over the support's dry friction there, if the way over which it builds up stays."""
    load_n: float
    source: str
    budget: tuple[Component, ...]

    @property
    def lines(self) -> str:
        """What to enter in the station, as it is written there."""
        lines = [
            "rig:",
            "  support_under_load:",
            f'    source: "{self.source}"',
            f"    load: {self.load_n:.6g} N",
            f"    torque: {1000 * self.torque.value:.2f} mN·m",
            f"    u: {1000 * self.torque.u:.2f} mN·m",
        ]
        if self.torque.dof < MOST_DOF:
            lines.append(f"    degrees_of_freedom: {self.torque.dof:.1f}")
        return "\n".join(lines)

    def document(self) -> dict[str, object]:
        """Return it for JSON."""
        return {
            "run_id": self.run_id,
            "torque_nm": self.torque.value,
            "u_nm": self.torque.u,
            "degrees_of_freedom": self.torque.dof if isfinite(self.torque.dof) else None,
            "expanded_nm": expanded(self.torque),
            "growth": self.growth.value,
            "growth_expanded": expanded(self.growth),
            "load_n": self.load_n,
            "source": self.source,
            "budget": {part.name: part.u for part in self.budget},
        }


def support_friction(path: Path, registry: Registry) -> SupportFriction:
    """Return what the load added to the support in a stored run; raise DataError.

    The run is one of the procedure `support_friction`, or one with the same inputs.
    """
    opened = open_run(path)
    run, stored = opened.data, opened.stored
    known_nm, limit_nm = (_torque_nm(run, name) for name in (KNOWN_FRICTION, KNOWN_LIMIT))
    procedure = parse_procedure(
        stored.header.procedure_text, stored.header.procedure_id, stored=True
    ).model
    # The station's entries on the support under load would be subtracted from what is measured.
    stated = {key: value for key, value in run.rig_keys.items() if key not in _STATED}
    result = analyse(
        replace(run, rig_keys={**stated, "support_drift": "0 %"}),
        procedure.analysis,
        acceptance=None,
        measurand=procedure.measurand,
        lookup=registry,
    )
    if problem := forbidden(check for check in _checks(result) if check.decisive):
        raise DataError(f"{run.run_id}: {problem}", hint="correct it and make the run again")
    details = TorqueDetails.of(result)
    start, support_line = _torque_and_support_line(result)
    running = details.compensations.get(RUNNING)
    under_way = compensated_mean(running.points).value if running and running.points else None
    total, slip = between(start, under_way)
    parts = (
        *(part for part in details.headline_components if part is not support_line),
        *_biases(result),
        *slip,
        Component(
            "friction of the known bearing", limit_nm / sqrt(3), inf, "rectangular", common=True
        ),
    )
    u, dof = combine(parts)
    torque = Estimate(total - known_nm, u, dof)
    dry_nm = abs(support_line.sensitivity)
    growth = Estimate(torque.value / dry_nm, u / dry_nm, dof, "1")
    if abs(growth.value) > MOST:
        raise DataError(
            f"{run.run_id}: the load adds {100 * growth.value:.0f} % to the support's friction, "
            f"beyond the bearing's {known_nm:g} N·m; at most {100 * MOST:.0f} % is possible",
            hint="was the bearing of known friction mounted, and is its friction entered right?",
        )
    words = [run.run_id, run.inputs.get("specimen", ""), run.inputs.get("certificate", "")]
    source = ", ".join(word.replace('"', "'") for word in words if word)
    return SupportFriction(
        run_id=run.run_id,
        torque=torque,
        growth=growth,
        load_n=max(point.load_n for point in details.loaded),
        source=source[:80].rstrip(", "),
        budget=parts,
    )


def _torque_and_support_line(result: Result) -> tuple[float, Component]:
    """Return the mean torque of a run, and the line of its budget that is for the support."""
    torque = TorqueDetails.of(result)
    for part in torque.headline_components:
        if part.name.startswith(SUPPORT_LINE) and part.sensitivity and torque.headline is not None:
            return torque.headline.value, part
    why = next((method.not_applicable for method in torque.compensations.values()), "")
    raise DataError(
        f"{result.run.run_id} has no starting torque with a line '{SUPPORT_LINE}' in its budget"
        + (f": {why}" if why else ""),
        hint="the procedure support_friction makes such runs",
    )


def between(start: float, under_way: float | None) -> tuple[float, tuple[Component, ...]]:
    """Return what the torque is where that of another bearing is read, and a line for it.

    The known bearing's own maximum may be elsewhere. Friction that builds up over another way under
    load is there too, and gone under way: in between lies what another bearing's maximum has of it.
    """
    if under_way is None:
        return start, ()
    half = abs(start - under_way) / 2
    line = Component(SLIP, half / sqrt(3), inf, "rectangular", common=True)
    return (start + under_way) / 2, (line,)


def _biases(result: Result) -> Iterator[Component]:
    """Yield what checks found that is too much of the run's small torque to be in its budget.

    Some compare with the torque: what they find of so small a one may be chance, and is no line.
    """
    for check in _checks(result):
        if check.consequence is Consequence.INCONCLUSIVE and check.biases:
            mean = check.biases[0]
            if abs(mean.value) > SIGNIFICANT * mean.u:
                yield Component(check.name, mean.contribution, inf, "normal", common=True)


def _checks(result: Result) -> tuple[Check, ...]:
    methods = TorqueDetails.of(result).compensations
    judged = (method for name, method in methods.items() if name != RUNNING)
    return (*result.checks, *(check for method in judged for check in method.checks))


def _torque_nm(run: RunData, name: str) -> float:
    text = run.inputs.get(name, "")
    if not text:
        raise DataError(
            f"{run.run_id} has no input '{name}': it does not say what its bearing's friction is",
            hint="the procedure support_friction asks for it",
        )
    return parse_quantity(text, "torque").si
