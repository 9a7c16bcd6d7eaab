"""What all parts of a certificate have in common."""

from __future__ import annotations

from typing import Annotated

from pydantic import AfterValidator, BaseModel, ConfigDict, Field

from rigrunner.api.texts import plain

Text = Annotated[str, Field(min_length=1), AfterValidator(plain)]

Sha256 = Annotated[str, Field(pattern=r"^([0-9a-f]{64})?$")]
"""A digest in hexadecimal; empty where there is none."""


class Part(BaseModel):
    """Frozen, strict, no unknown keys: the base of all that a certificate consists of."""

    model_config = ConfigDict(
        extra="forbid", frozen=True, strict=True, allow_inf_nan=False, use_attribute_docstrings=True
    )
