"""Refusals that models word themselves."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pydantic_core import PydanticCustomError

if TYPE_CHECKING:
    from rigrunner.api.settings import Settings


def refusal(message: str, hint: str = "") -> PydanticCustomError:
    """Return what a validator raises to refuse a value with these very words."""
    return PydanticCustomError("refused", "{message}", {"message": message, "hint": hint})


def require_one(model: Settings, first: str, second: str) -> None:
    """Refuse a model of which not exactly one of two keys is given."""
    names = [name for name in (first, second) if getattr(model, name) is not None]
    if len(names) != 1:
        got = "both" if names else "neither"
        raise refusal(f"got {got}, expected one of: {first}, {second}")
