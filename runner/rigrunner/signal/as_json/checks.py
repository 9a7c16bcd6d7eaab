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
            "name": each.name,
            "ok": each.ok,
            "text": each.text,
            "advice": each.advice,
            "value": None if each.value is None else number(each.value),
            "threshold": None if each.threshold is None else number(each.threshold),
            "unit": each.unit or None,
            "biases": [
                {
                    "of": bias.of,
                    "value": number(bias.value),
                    "standard_uncertainty": number(bias.u),
                    "unit": bias.unit,
                }
                for bias in each.biases
            ],
            "consequence": each.consequence or None,
            "effect": effect_words(each),
        }
        for each in checks
    ]
