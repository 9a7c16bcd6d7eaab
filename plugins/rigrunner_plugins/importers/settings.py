"""Settings of the importers: how text files are written."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from rigrunner.api import Settings, YesNo

Encoding = Literal["utf-8", "latin-1", "utf-16"]


class TableSettings(Settings):
    """How CSV files are written."""

    delimiter: Literal[",", ";", "tab", "|"] = ","
    """Separator of columns."""
    decimal: Literal[".", ","] = "."
    """Decimal mark."""
    header: Annotated[YesNo, Field(description="whether a line names the columns")] = True
    columns: Annotated[
        int | None,
        Field(ge=1, description="number of columns without a header, if not all are used"),
    ] = None
    skip_lines: Annotated[int, Field(ge=0, description="lines before header or numbers")] = 0
    encoding: Encoding = "utf-8"
    """Encoding of the text."""

    @model_validator(mode="after")
    def _distinct(self) -> Self:
        if self.delimiter == self.decimal:
            raise ValueError("delimiter and decimal are the same")
        return self


class LvmSettings(Settings):
    """How LVM files are written, where they do not state it."""

    decimal: Annotated[
        Literal[".", ","],
        Field(description="the decimal mark where the file does not state it (version < 2)"),
    ] = "."
    encoding: Encoding = "utf-8"
    """Encoding of the text."""
