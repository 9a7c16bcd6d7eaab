"""The figure of a curve: its points, the curve with its band, and what is left over."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api.data import Estimate
from rigrunner.api.findings import Figure, Panel, Series
from rigrunner.api.units import unit
from rigrunner.signal.coverage import factor

if TYPE_CHECKING:
    from rigrunner.api.data import Array
    from rigrunner_plugins.analyses.curve.derived import Fitted

SAMPLES = 100


def figure_of(fitted: Fitted, of: str, x: str, y: str, place: str) -> Figure:
    """Return the figure of a curve over one regressor; it stands with the result `of`.

    The band is the coverage interval of the curve for 95 %, by the scatter about it.
    """
    values = fitted.values
    x_unit, y_unit = _shown(values.units[0]), _shown(values.y_unit)
    grid = np.linspace(*fitted.ends, SAMPLES)
    line, u = fitted.at(grid)
    dof = fitted.curve.dof
    k = factor(Estimate(0.0, 1.0, dof if dof > 0 else float("inf")))
    at = _numbers(values.x[:, 0] + values.origin, x_unit)
    over = _numbers(grid + values.origin, x_unit)
    band = tuple((k * u / unit(y_unit).factor).tolist())
    left = values.y - fitted.at(values.x[:, 0])[0]
    return Figure(
        of=of,
        caption=f"{y} over {x}{place}: points, curve with its 95 % band, and residuals.",
        x=_axis(x, x_unit),
        panels=(
            Panel(
                y=_axis(y, y_unit),
                series=(
                    Series(name="curve", x=over, y=_numbers(line, y_unit), U=band, line=True),
                    Series(name="points", x=at, y=_numbers(values.y, y_unit)),
                ),
            ),
            Panel(
                y=_axis("residual", "K" if y_unit == "°C" else y_unit),
                series=(
                    Series(name="curve", x=over, y=(0.0,) * SAMPLES, U=band, line=True),
                    Series(name="residuals", x=at, y=tuple(left.tolist())),
                ),
            ),
        ),
    )


def _shown(si: str) -> str:
    return "°C" if unit(si).dimension == "temperature" else si


def _numbers(si: Array, symbol: str) -> tuple[float, ...]:
    shown = unit(symbol)
    return tuple(((si - shown.offset) / shown.factor).tolist())


def _axis(name: str, symbol: str) -> str:
    return name if symbol == "1" else f"{name} / {symbol}"
