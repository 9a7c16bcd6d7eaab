"""What no single setting of an analysis of torque can see: settings that contradict each other."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

from rigrunner.api import DataError
from rigrunner.api.planned import PlanProblem

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigrunner_bearings.torque.settings import TorqueSettings

_OF_COMPENSATIONS = ("compensations", "primary_", "no_load")


def contradictions(spec: TorqueSettings) -> Iterator[PlanProblem]:
    """Yield what contradicts each other in settings, each with its place in them."""
    names = [reference.label for reference in spec.compensations]
    allowed = ", ".join(names) or "none, as there are no compensations"
    if spec.primary_ and spec.primary_ not in names:
        message = f"got '{spec.primary_}', which is not among the compensations"
        yield PlanProblem(message=message, hint=f"allowed: {allowed}", key=("primary",))
    if names and not spec.primary:
        hint = f"say which one counts: {allowed}"
        message = "the key 'primary' is missing"
        yield PlanProblem(message=message, hint=hint, key=("primary",), at_key=True)
    if names and spec.no_load is None and spec.starts is None:
        hint = "compensations need it: 'no_load: {from: latest, procedure: ID}'"
        message = "the key 'no_load' is missing"
        yield PlanProblem(message=message, hint=hint, key=("no_load",), at_key=True)
    if spec.validate_ is not None and not names:
        hint = "add 'compensations' to the analysis, or leave 'validate' out"
        message = "there is no compensated torque to validate"
        yield PlanProblem(message=message, hint=hint, key=("validate",))
    for key, labels in (("fits", [fit.label for fit in spec.fits]), ("compensations", names)):
        seen = Counter[str]()
        for index, label in enumerate(labels):
            if seen[label]:
                hint = "name it once, or give this one a name of its own: 'as: NAME'"
                message = f"'{label}' is given twice"
                yield PlanProblem(message=message, hint=hint, key=(key, index))
            seen[label] += 1


def changed(spec: TorqueSettings, overrides: TorqueSettings) -> TorqueSettings:
    """Return settings with the set fields of `overrides` in place; raise DataError 'KEY: why'.

    Settings without compensations, such as those of a no-load run, stay without.
    """
    updates = {name: getattr(overrides, name) for name in overrides.model_fields_set}
    if not spec.compensations:
        updates = {name: value for name, value in updates.items() if name not in _OF_COMPENSATIONS}
    merged = spec.model_copy(update=updates)
    for problem in contradictions(merged) if updates else ():
        raise DataError(f"{problem.key[0]}: {problem.message}", hint=problem.hint)
    return merged
