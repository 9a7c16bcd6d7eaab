"""The record of the analysis of torque, as documents take it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api.details import PlotColumn, RunPlot
from rigrunner_bearings.api.torque import TorqueDetails
from rigrunner_bearings.torque.document import TORQUE, settings_document, torque_document
from rigrunner_bearings.torque.settings import NO_LOAD

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigrunner.api import RunData
    from rigrunner.api.analysis_context import Plugins
    from rigrunner.api.certificate import CertifiedDetails
    from rigrunner_bearings.torque.settings import TorqueSettings


@dataclass(frozen=True, eq=False, kw_only=True)
class DocumentedTorque(TorqueDetails):
    """What the analysis of torque keeps, with what documents state of it."""

    spec: TorqueSettings
    plugins: Plugins

    def settings(self) -> Mapping[str, object]:
        """Return the settings as every result records them, with the defaults of the plugins."""
        return settings_document(self.spec, self.plugins)

    def document(self) -> Mapping[str, object]:
        """Return its parts of `result.json`."""
        return torque_document(self)

    def plot(self) -> RunPlot | None:
        """Return raw and compensated torque of the primary method; None where there is none."""
        primary = self.compensations.get(self.primary)
        if primary is None or not primary.points:
            return None
        found = primary.points
        raw = [each.peak_nm[each.peak_kept].mean() for each in self.loaded]
        columns = {
            "frequency": ([each.frequency_hz for each in found], "Hz", "frequency"),
            "compensated": ([each.torque.value for each in found], TORQUE, "compensated torque"),
            "compensated_errors": (
                [each.torque.u for each in found],
                TORQUE,
                "standard uncertainty",
            ),
            "raw": (raw, TORQUE, "raw peak torque"),
        }
        return RunPlot(
            name="torque",
            title="torque over frequency",
            columns={
                name: PlotColumn(np.array(values), unit, f"{long_name} / {unit}")
                for name, (values, unit, long_name) in columns.items()
            },
            axis="frequency",
            signal="compensated",
            beside=("raw",),
        )

    def certified(self, run: RunData) -> CertifiedDetails:
        """Return its parts of a certificate; raise DataError where it gave no result."""
        from rigrunner_bearings.torque.certified import certified_torque  # noqa: PLC0415  (pydantic)

        return certified_torque(self, run, run.partners.get(NO_LOAD))
