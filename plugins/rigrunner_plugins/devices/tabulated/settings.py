"""Settings of the tabulated device; loads without numpy."""

from __future__ import annotations

from typing import Annotated, Self

from pydantic import Field, model_validator

from rigrunner.api import AnyQuantity, ListOf, Settings
from rigrunner.api.names import Name
from rigrunner.api.units import si_symbol, with_article

Row = dict[Name, AnyQuantity]


class TabulatedSettings(Settings):
    """A table: some columns are set-points, the others the values read there."""

    title: Annotated[str, Field(min_length=1, description="source of the values")]
    set_points: Annotated[
        ListOf[str], Field(min_length=1, description="the columns that are drives")
    ]
    cycle_frequency: Annotated[
        str,
        Field(description="the drive that sets the frequency of a cyclic motion, if there is one"),
    ] = ""
    rows: Annotated[
        ListOf[Row],
        Field(min_length=1, description="rows, each with a value and its unit for every column"),
    ]

    @property
    def columns(self) -> tuple[str, ...]:
        """The names of all columns, as the first row has them."""
        return tuple(self.rows[0])

    @property
    def channels(self) -> tuple[str, ...]:
        """The columns that are read."""
        return tuple(name for name in self.columns if name not in self.set_points)

    def unit(self, column: str) -> str:
        """Return the SI unit of a column."""
        return si_symbol(self.rows[0][column].dimension)

    def written_in(self, column: str) -> str:
        """Return the unit in which a column begins."""
        return self.rows[0][column].unit.symbol

    def place(self, row: Row) -> tuple[float, ...]:
        """Return where a row stands: its set-points in SI units."""
        return tuple(row[name].si for name in self.set_points)

    @model_validator(mode="after")
    def _is_a_table(self) -> Self:
        missing = [name for name in self.set_points if name not in self.columns]
        if missing:
            raise ValueError(
                f"set_points names '{missing[0]}', which is not a column;"
                f" the first row has: {', '.join(self.columns)}"
            )
        if not self.channels:
            raise ValueError("every column is a set-point: no column is left to read")
        if self.cycle_frequency and self.cycle_frequency not in self.set_points:
            raise ValueError(
                f"cycle_frequency names '{self.cycle_frequency}', which is not among set_points"
            )
        self._check_rows()
        return self

    def _check_rows(self) -> None:
        first: dict[tuple[float, ...], int] = {}
        for number, row in enumerate(self.rows, start=1):
            if set(row) != set(self.columns):
                raise ValueError(
                    f"row {number} has {', '.join(row) or 'nothing'};"
                    f" the first row has {', '.join(self.columns)}"
                )
            for name, value in row.items():
                dimension = self.rows[0][name].dimension
                if value.dimension != dimension:
                    raise ValueError(
                        f"row {number}, {name}: got '{value}', expected {with_article(dimension)}"
                    )
            place = tuple(float(f"{value:.9g}") for value in self.place(row))  # 1 L/min is 60 L/h
            earlier = first.setdefault(place, number)
            if earlier != number:
                raise ValueError(f"rows {earlier} and {number} have the same set-points")
