"""What follows from the judgement on the values that a step found."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.events import LimitMissed, Note
from rigrunner.api.limits import Judgement

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from rigrunner.api.limits import ValueLimit

Remark = tuple[type[Note], str]
"""An event that tells of a judgement, and its text."""


def remarks_on(
    limits: Sequence[ValueLimit], values: Mapping[str, float], where: str = ""
) -> Iterator[Remark]:
    """Yield what is to be put on record of values: which are out of limits, which are marginal.

    `values` are in SI units, by the name that the limits have for them; `where` begins each text.
    """
    for limit in limits:
        value, (least, greatest) = values[limit.of], limit.clear
        if least <= value <= greatest:
            continue
        judged = Judgement(limit, value)
        if not judged.passes:
            yield LimitMissed, f"{where}{judged.text}"
        elif judged.is_marginal:
            yield Note, f"{where}{judged.text}"


def missed_text(remarks: Sequence[Remark]) -> str:
    """Return which values are out of limits, as one text; '' for none."""
    return "; ".join(text for kind, text in remarks if kind is LimitMissed)
