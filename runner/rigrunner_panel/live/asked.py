"""What the panel asks the analyst's process, and what it is told."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pathlib import Path

    import numpy as np
    from numpy.typing import NDArray

    from rigrunner.api.data import Recording
    from rigrunner_panel.view.sections import LiveView


LIVE = "live"
"""The name of a recording that is watched and kept nowhere."""


@dataclass(frozen=True, eq=False)
class Analyse:
    """Analyse a run as far as it is; or what is watched, by the run's own analysis."""

    folder: Path
    station: Path
    no_load: Path | None
    recording: str
    watched: Recording | None = None


@dataclass(frozen=True, eq=False)
class Analysed:
    """What was found; `correction_nm` is taken from the swing of that recording, shape (N,)."""

    view: LiveView | None
    recording: str = ""
    correction_nm: NDArray[np.float64] | None = None
