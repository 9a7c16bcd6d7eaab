"""Raw and compensated torque over frequency."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rigrunner.plots.canvas import BLUE, INK, VERMILION, drawn

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.figure import Figure

    from rigrunner.api.data import Array
    from rigrunner.plots.canvas import Plot


def torque_over_frequency(
    frequency_hz: Array,
    raw_nm: Array,
    torque_nm: Array,
    expanded_nm: Array,
    *,
    title: str = "",
    limits_nm: Sequence[float] = (),
) -> Plot:
    """Return the plot of arrays of shape (n,); NaN where there is nothing, and of U no bar."""

    def paint(figure: Figure) -> None:
        axes = figure.subplots()
        axes.plot(frequency_hz, raw_nm, "s--", color=VERMILION, label="raw peak")
        if np.isfinite(torque_nm).any():
            bars = np.nan_to_num(expanded_nm, nan=0.0)
            label = "compensated, with U (95 %)"
            axes.errorbar(frequency_hz, torque_nm, bars, fmt="o-", color=BLUE, label=label)
        for limit in limits_nm:
            axes.axhline(limit, color=INK, linewidth=1, linestyle=(0, (6, 3)), label="limit")
        axes.set(title=title, xlabel="frequency / Hz", ylabel="torque / N·m")
        axes.legend()

    return drawn(paint)
