"""What an analysis adds to a certificate."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rigrunner.api.certificate.method import ValidityCondition
    from rigrunner.api.certificate.remarks import Deviation
    from rigrunner.api.certificate.results import RejectedCycle, Results


@dataclass(frozen=True, kw_only=True)
class CertifiedDetails:
    """The parts of a certificate that one analysis brings."""

    results: Results | None = None
    """Its results with their set-points; None where it states none."""
    method: str = ""
    """The method whose result counts, by its name in the procedure."""
    quantity: str = ""
    """What that method measures, in words."""
    validity: tuple[ValidityCondition, ...] = ()
    """On what its results are conditional."""
    channels: frozenset[str] = frozenset()
    """The channels whose calibrations its results rest on."""
    deviations: tuple[Deviation, ...] = ()
    rejected: tuple[RejectedCycle, ...] = ()
