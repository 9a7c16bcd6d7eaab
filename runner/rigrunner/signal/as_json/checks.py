"""Checks in the content of `result.json`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.checks import effect_words
from rigrunner.signal.as_json.values import number

if TYPE_CHECKING:
    from collections.abc import Iterable

    from rigrunner.api.analysis import Check
    from rigrunner.signal.as_json.values import Json


def checks_of(checks: Iterable[Check]) -> list[Json]:
    """Return checks, each with its effect on the result in words."""
    return [
        {
            "name": check.name,
            "ok": check.ok,
            "text": check.text,
            "advice": check.advice,
            "value": None if check.value is None else number(check.value),
            "threshold": None if check.threshold is None else number(check.threshold),
            "unit": check.unit or None,
            "biases": [
                {
                    "of": bias.of,
                    "value": number(bias.value),
                    "standard_uncertainty": number(bias.u),
                    "unit": bias.unit,
                }
                for bias in check.biases
            ],
            "consequence": check.consequence or None,
            "effect": effect_words(check),
        }
        for check in checks
    ]
