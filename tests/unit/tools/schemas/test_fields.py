"""The description of settings fields in words."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Literal

import pytest
from pydantic import Field, WithJsonSchema

from rigrunner.api.settings import (
    Angle,
    AnyQuantity,
    Frequency,
    IsoDate,
    Length,
    ListOf,
    Ratio,
    Settings,
    WrapperSettings,
    YesNo,
)
from rigrunner.tools.schemas.fields import all_fields, fields_of


class Inner(Settings):
    gain: Annotated[Ratio, Field(ge=0, le=0.05)] = 0.02


class Base(Settings):
    depth: Length
    """How deep."""


class Column(Settings):
    unit: str


class Example(Base):
    from_: Annotated[str, Field(alias="from")] = ""
    cycles: Annotated[int, Field(ge=1, description="how many")] = 30
    alpha: Annotated[float, Field(gt=0, lt=0.5)] = 0.05
    side: Literal["both", "high"] = "both"
    weighted: bool = False
    sure: YesNo = True
    window: Annotated[Angle | None, Field(gt=0)] = None
    over: ListOf[Frequency] = (1.0, 2000.0)
    words: ListOf[str] = ()
    value: AnyQuantity | None = None
    due: IsoDate | None = None
    inner: Inner = Inner()
    columns: dict[str, Column] = Field(default_factory=dict)
    points: ListOf[Column] = ()
    names: dict[str, int] = Field(default_factory=dict)
    column: int | str | None = None
    mark: Literal[",", ";"] = ","


FIELDS = {field.key: field for field in fields_of(Example)}


@pytest.mark.parametrize(
    ("key", "kind", "units", "bounds", "default"),
    [
        ("depth", "length", ("m", "mm", "µm"), "", None),
        ("from", "text", (), "", None),
        ("cycles", "whole number", (), "at least 1", 30),
        ("alpha", "number", (), "more than 0, less than 0.5", 0.05),
        ("side", "both | high", (), "", "both"),
        ("weighted", "true | false", (), "", False),
        ("sure", "yes | no", (), "", True),
        ("window", "angle", ("rad", "mrad", "deg", "arcmin", "arcsec"), "more than 0", None),
        ("over", "list of frequency", ("Hz", "kHz", "rpm"), "", ["1 Hz", "2 kHz"]),
        ("words", "list of text", (), "", None),
        ("value", "quantity", (), "", None),
        ("due", "date", (), "", None),
        ("inner", "settings", (), "", None),
        ("column", "whole number or text", (), "", None),
        ("mark", '"," | ";"', (), "", ","),
        ("names", "mapping of names to whole number", (), "", None),
    ],
)
def test_field_is_described(key, kind, units, bounds, default):
    field = FIELDS[key]
    assert (field.kind, field.units, field.bounds, field.default) == (kind, units, bounds, default)


def test_bounds_and_defaults_of_quantities_have_units():
    (gain,) = fields_of(Inner)
    assert (gain.bounds, gain.default) == ("at least 0, at most 5 %", "2 %")


def test_nested_fields_have_their_path():
    nested = [name for name, _ in all_fields(Example) if "." in name]
    assert nested == ["inner.gain", "columns.NAME.unit", "points[].unit"]


class Wired(Settings):
    inputs: Annotated[Mapping[str, Inner], Field(description="what it reads")]
    start: Annotated[
        Mapping[str, Annotated[float, WithJsonSchema({"type": ["number", "string"]})]],
        Field(description="where it begins"),
    ]
    names: Annotated[str, WithJsonSchema({"pattern": "a*", "type": "string"})] = ""


def test_fields_with_a_custom_schema_are_described():
    kinds = {name: field.kind for name, field in all_fields(Wired)}
    assert kinds == {
        "inputs": "mapping of names to settings",
        "inputs.NAME.gain": "ratio",
        "start": "mapping of names to number or text",
        "names": "text",
    }


def test_help_is_the_description_or_the_docstring_of_the_field():
    assert FIELDS["cycles"].help == "how many"
    assert FIELDS["depth"].help == "How deep."
    assert FIELDS["alpha"].help == ""


def test_fields_have_their_model_and_whether_they_are_required():
    assert FIELDS["inner"].model is Inner
    assert [key for key, field in FIELDS.items() if field.required] == ["depth"]


def test_model_without_source_has_no_help():
    namespace: dict[str, object] = {}
    code = "class Made(Settings):\n    depth: int = 1\n    '''How deep.'''\n"
    exec(compile(code, "<made>", "exec"), {"Settings": Settings, "__name__": "made"}, namespace)  # noqa: S102  (a class without a source file)
    assert [field.help for field in fields_of(namespace["Made"])] == [""]


def test_fields_of_a_wrapper_are_described():
    kinds = {field.key: field.kind for field in fields_of(WrapperSettings)}
    assert kinds == {"plugin": "text", "settings": "mapping of names to anything"}
