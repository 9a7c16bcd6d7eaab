"""The figures of a curve: its points with the fitted curve and its band, and the residuals."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api import Estimate, unit
from rigrunner.api.figures import Axis, Figure, Series
from rigrunner.signal.coverage import factor

if TYPE_CHECKING:
    from rigrunner.api import Array
    from rigrunner_plugins.analyses.curve.derived import Fitted

SAMPLES = 100


def figures_of(fitted: Fitted, of: str, x: str, y: str, place: str) -> tuple[Figure, Figure]:
    """Return the figures of the curve over one regressor and of its residuals, for the result `of`.

    The band is the 95 % coverage interval of the curve, from the scatter about it.
    """
    values = fitted.values
    x_unit, y_unit = values.shown[0], values.y_shown
    grid = np.linspace(*fitted.ends, SAMPLES)
    line, u = fitted.at(grid)
    dof = fitted.curve.dof
    k = factor(Estimate(0.0, 1.0, dof if dof > 0 else float("inf")))
    at = _numbers(values.x[:, 0] + values.origin, x_unit)
    over = _numbers(grid + values.origin, x_unit)
    band = k * u / unit(y_unit).factor
    residual_values = (values.y - fitted.at(values.x[:, 0])[0]) / unit(y_unit).factor
    x_axis = Axis(x, x_unit)
    curve = Figure(
        title=f"{y} over {x}{place}",
        x=x_axis,
        y=Axis(y, y_unit),
        series=(
            Series.over(over, _numbers(line, y_unit), "curve", "line", U=band),
            Series.over(at, _numbers(values.y, y_unit), "points"),
        ),
        of=of,
        caption=f"{y} over {x}{place}: points, and the curve with its 95 % band.",
    )
    residuals = Figure(
        title=f"residuals of {y}{place}",
        x=x_axis,
        y=Axis("residual", "K" if y_unit == "°C" else y_unit),
        series=(
            Series.over(over, [0.0] * SAMPLES, "curve", "line", U=band),
            Series.over(at, residual_values, "residuals"),
        ),
        of=of,
        caption=f"Residuals of {y} over {x}{place}, within the curve's 95 % band.",
    )
    return curve, residuals


def _numbers(si: Array, symbol: str) -> list[float]:
    shown = unit(symbol)
    return list(((si - shown.offset) / shown.factor).tolist())
