"""Fields of settings whose defaults are written as a person would write them."""

from __future__ import annotations

from typing import Any

from pydantic import Field


def quantity(text: str, description: str, **limits: float) -> Any:
    """Return a field with a default that is written, and read, with its unit; limits are in SI."""
    return Field(default=text, validate_default=True, description=description, **limits)  # type: ignore[call-overload]  # limits are its own keywords
