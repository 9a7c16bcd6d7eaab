"""Time-outs, attempts and limits of a step, checked against what the step does."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.limits import ValueLimit
from rigrunner.api.readings import ReadingLimit
from rigrunner.plan.actions import Terms

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, Sequence

    from rigrunner.api.devices import ReadingInfo
    from rigrunner.api.member import Member
    from rigrunner.api.quantity import Quantity
    from rigrunner.api.steps import StepSettings
    from rigrunner.plan.draft import Place, Scene
    from rigrunner.procedure.options import Bounds, RecordedBand, ValueBand
    from rigrunner.yamlfile.document import Path

_YES_NO = {"yes": True, "no": False, "True": True, "False": False}
"""By the texts of what YAML gives: 'yes' is a text there, and true a bool."""


def terms_of(
    step: StepSettings,
    place: Place,
    seconds: float,
    scene: Scene,
    limits: Iterable[ValueLimit] | None,
    *,
    expected: Iterable[ReadingLimit] = (),
) -> Terms:
    """Return the terms of a step that takes so long; a time-out that is too short is a problem.

    They are its fields `timeout`, `retries` and `repeatable`, as far as its kind has them; where
    its values have limits, or may have, also `on_fail`.
    """
    fields = vars(step)  # `getattr` is slow for a field that a kind of step lacks
    timeout_s = fields.get("timeout")
    if timeout_s is not None and timeout_s < seconds:
        message = f"got {timeout_s:g} s, but the step takes {seconds:.3g} s"
        scene.complain((*place.path, "timeout"), message)
    attempts, repeatable = fields.get("retries", 0) + 1, fields.get("repeatable", True)
    if limits is None:
        return Terms(timeout_s, attempts, repeatable=repeatable)
    stops = fields.get("on_fail", "stop") == "stop"
    return Terms(
        timeout_s,
        attempts,
        not stops,
        tuple(limits),
        tuple(expected),
        stops_at_limit=stops,
        repeatable=repeatable,
    )


def planned_limits(
    bands: Mapping[Member, ValueBand], place: Place, channels: Sequence[str], scene: Scene
) -> Iterator[ValueLimit]:
    """Yield the limits of channels; what does not fit them is a problem."""
    for member, band in bands.items():
        path = (*place.path, "limits", member)
        channel = scene.bench.channel(member, path, key=True)
        if channel is None:
            continue
        if member not in channels:
            _refuse_unread(member, channels, path, scene)
        elif band.texts:
            key = "equals" if band.equals is not None else "one_of"
            message = f"{member} is a number, which has 'min' and 'max'"
            scene.complain((*path, key), message, "a number is never exactly the same", key=True)
        elif _fits(band, channel.unit, member, path, scene):
            yield _limit(member, band.min, band.max, band)


def reading_limits(
    bands: Mapping[Member, ValueBand],
    infos: Mapping[Member, ReadingInfo],
    place: Place,
    scene: Scene,
) -> Iterator[ReadingLimit]:
    """Yield the limits of readings that are no numbers; what does not fit them is a problem."""
    for member, band in bands.items():
        kind, path = infos[member].kind, (*place.path, "limits", member)
        if kind == "array":
            scene.complain(path, f"{member} is an array, which has no limits", key=True)
        elif not band.texts:
            key = next(name for name in ("min", "max") if getattr(band, name) is not None)
            message = f"{member} is a {kind}, which has 'equals' and 'one_of'"
            scene.complain((*path, key), message, "only numbers have 'min' and 'max'", key=True)
        else:
            allowed = tuple(_YES_NO.get(str(text), text) for text in band.texts)
            wrong = [text for text in allowed if isinstance(text, bool) != (kind == "boolean")]
            if kind == "boolean" and not wrong:
                yield ReadingLimit(member, allowed)
            elif kind == "text" and all(isinstance(text, str) for text in band.texts):
                # As written: 'yes' may be the very text that an instrument gives.
                yield ReadingLimit(member, band.texts)
            else:
                expected = "yes or no" if kind == "boolean" else "a text; put it in quotes"
                key = "equals" if band.equals is not None else "one_of"
                scene.complain((*path, key), f"{member} is a {kind}: expected {expected}")


def recorded_limits(
    bands: Mapping[Member, RecordedBand],
    channels: Sequence[Member],
    beside: Sequence[str],
    place: Place,
    scene: Scene,
) -> Iterator[ValueLimit]:
    """Yield the limits of a recording: of samples of its channels, and of values read `beside`.

    What does not fit them is a problem.
    """
    for member, band in bands.items():
        path = (*place.path, "limits", member)
        channel = scene.bench.channel(member, path, key=True)
        if channel is None:
            continue
        recorded = member in channels
        if not recorded and member not in beside:
            _refuse_unread(member, (*channels, *beside), path, scene)
            continue
        if not recorded and band.statistics:
            name, hint = next(iter(band.statistics)), "limit it by min and max, or record it"
            message = f"{member} is read once beside the recording, and has no {name}"
            scene.complain((*path, name), message, hint, key=True)
            continue
        fits = [_fits(band, channel.unit, member, path, scene)]
        for name, bounds in band.statistics.items():
            fits.append(_fits(bounds, channel.unit, member, (*path, name), scene))
        if not all(fits):
            continue
        if not recorded:
            yield _limit(member, band.min, band.max, band)
            continue
        for name, (low, high) in band.of_samples.items():
            yield _limit(f"{member}.{name}", low, high, band)
        for name, bounds in band.statistics.items():
            yield _limit(f"{member}.{name}", bounds.min, bounds.max, bounds)


def _limit(of: str, low: Quantity | None, high: Quantity | None, band: Bounds) -> ValueLimit:
    return ValueLimit.between(of, low, high, band.marginal.si if band.marginal else 0.0)


def _refuse_unread(member: Member, channels: Sequence[str], path: Path, scene: Scene) -> None:
    hint = f"it finds: {', '.join(channels) or 'none'}"
    scene.complain(path, f"the step finds no value of {member}", hint, key=True)


def _fits(band: Bounds, symbol: str, member: Member, path: Path, scene: Scene) -> bool:
    """Say whether bounds have the dimension of a channel; each that has not is a problem."""
    quantities = {"min": band.min, "max": band.max, "marginal": band.marginal}
    return all(
        scene.bench.fits(quantity, symbol, member, (*path, name))
        for name, quantity in quantities.items()
        if quantity
    )
