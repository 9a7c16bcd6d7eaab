"""Numbers with the digits that their uncertainty justifies."""

from __future__ import annotations

import math

from rigrunner.signal.rounding import places


def with_uncertainty(value: float, expanded: float) -> str:
    """Return 'value ± U', U with two significant digits and the value to the same place.

    This is the rounding of GUM 7.2.6. An uncertainty that is zero or not finite is shown as it is.
    """
    if not (math.isfinite(expanded) and expanded > 0):
        return f"{value:.4g} ± {expanded:.2g}"
    decimals = max(0, places(expanded))
    return f"{value:.{decimals}f} ± {expanded:.{decimals}f}"
