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
    """The parts of a certificate that one analysis provides."""

    results: Results | None = None
    """Its results with their set-points; None if it states none."""
    method: str = ""
    """Name of the primary method in the procedure."""
    quantity: str = ""
    """The quantity that it yields, in words."""
    validity: tuple[ValidityCondition, ...] = ()
    """The conditions on which its results hold."""
    channels: frozenset[str] = frozenset()
    """The channels whose calibrations its results depend on."""
    deviations: tuple[Deviation, ...] = ()
    rejected: tuple[RejectedCycle, ...] = ()
