"""A fit named in settings; the plugin receives the fit itself."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, ClassVar

from pydantic import Field, model_validator

from rigrunner.api.settings import Settings

if TYPE_CHECKING:
    from collections.abc import Mapping


class FitChoice(Settings):
    """A fit by its name, or as `name: {setting: value}`.

    The factory of a plugin with a field of this type gets the fit itself too, as a keyword argument
    with the name of the field: `factory(settings, fit=...)`.
    """

    kind: ClassVar[str] = "fit"
    name: Annotated[str, Field(min_length=1)]
    """Of the fit."""
    settings: dict[str, Any] = Field(default_factory=dict)
    """Its settings."""

    @model_validator(mode="before")
    @classmethod
    def _read(cls, value: object) -> object:
        if isinstance(value, str):
            return {"name": value}
        if not isinstance(value, dict) or len(value) != 1:
            raise ValueError("a fit is written as 'name', or as 'name: {setting: value}'")
        ((name, settings),) = value.items()
        if not isinstance(settings, dict | None):
            raise ValueError(f"the settings of '{str(name)[:40]}' are a mapping")  # noqa: TRY004  (pydantic places it)
        return {"name": name, "settings": settings or {}}


def chosen_fits(settings: Settings) -> Mapping[str, FitChoice]:
    """Return the fits that settings name, by the fields that do."""
    return {name: value for name, value in settings if isinstance(value, FitChoice)}
