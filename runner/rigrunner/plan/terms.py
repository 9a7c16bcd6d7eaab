"""Time-outs, tries and limits of a step, checked against what the step does."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from rigrunner.plan.actions import Limit, Terms

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from rigrunner.plan.draft import Place, Scene
    from rigrunner.procedure import doings
    from rigrunner.procedure.options import Band

    Judged = doings.Zero | doings.Record | doings.Measure
    Tried = doings.Set | doings.Ramp | doings.Scan | Judged


def tried_terms(step: Tried, place: Place, seconds: float, scene: Scene) -> Terms:
    """Return the terms of a step that takes so long; a time-out that is too short is a problem."""
    if step.timeout is not None and step.timeout < seconds:
        message = f"got {step.timeout:g} s, but the step takes {seconds:.3g} s"
        scene.complain((*place.path, "timeout"), message)
    return Terms(step.timeout, step.retries + 1, repeatable=step.repeatable)


def judged_terms(
    step: Judged, place: Place, seconds: float, found: Sequence[str], scene: Scene
) -> Terms:
    """Return the terms of a step that finds values of the channels `found`, 'role.name'."""
    terms = tried_terms(step, place, seconds, scene)
    limits = tuple(planned_limits(step.limits, place, found, scene))
    return replace(terms, goes_on=step.on_fail == "continue", limits=limits)


def planned_limits(
    bands: Mapping[str, Band], place: Place, found: Sequence[str], scene: Scene
) -> Iterator[Limit]:
    """Yield the limits of the channels `found`; what does not fit them is a problem."""
    for member, band in bands.items():
        path = (*place.path, "limits", member)
        channel = scene.bench.channel(member, path, key=True)
        if channel is None:
            continue
        if member not in found:
            hint = f"it finds: {', '.join(found) or 'none'}"
            scene.complain(path, f"the step finds no value of {member}", hint, key=True)
            continue
        given = {"min": band.min, "max": band.max, "marginal": band.marginal}
        at = ((quantity, (*path, name)) for name, quantity in given.items() if quantity)
        if all(scene.bench.fits(quantity, channel.unit, member, where) for quantity, where in at):
            yield Limit(member, band.min, band.max, band.marginal.si if band.marginal else 0.0)
