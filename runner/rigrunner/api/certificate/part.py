"""The common base of all parts of a certificate."""

from __future__ import annotations

from typing import Annotated

from pydantic import AfterValidator, BaseModel, ConfigDict, Field

from rigrunner.api.texts import plain

Text = Annotated[str, Field(min_length=1), AfterValidator(plain)]

Sha256 = Annotated[str, Field(pattern=r"^([0-9a-f]{64})?$")]
"""A digest in hexadecimal; empty for none."""


class Part(BaseModel):
    """The base of all parts of a certificate: frozen, strict, without unknown keys."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False)
