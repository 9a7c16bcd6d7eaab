"""The record of the analysis of torque, as documents take it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from rigrunner.analysis.torque.document import torque_document
from rigrunner.api.torque import TorqueDetails

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from rigrunner.api.certificate import CertifiedDetails
    from rigrunner.api.data import RunData


@dataclass(frozen=True, eq=False, kw_only=True)
class DocumentedTorque(TorqueDetails):
    """What the analysis of torque keeps, with what documents state of it."""

    def document(self) -> Mapping[str, object]:
        """Return its parts of `result.json`."""
        return torque_document(self)

    def certified(self, run: RunData, partners: Sequence[RunData]) -> CertifiedDetails:
        """Return its parts of a certificate; raise DataError where it gave no result."""
        from rigrunner.analysis.torque.certified import certified_torque  # noqa: PLC0415  (pydantic)

        return certified_torque(self, run, next(iter(partners), None))
