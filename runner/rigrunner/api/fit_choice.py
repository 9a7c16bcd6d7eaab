"""A fit named in settings; the plugin gets the fit itself."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, ClassVar

from pydantic import Field, model_validator

from rigrunner.api.settings import Settings

if TYPE_CHECKING:
    from collections.abc import Mapping


class FitChoice(Settings):
    """A fit by name, or as `name: {setting: value}`.

    The factory of a plugin with a field of this type also gets the fit, as a keyword argument with
    the name of the field: `factory(settings, fit=...)`.
    """

    kind: ClassVar[str] = "fit"
    name: Annotated[str, Field(min_length=1)]
    """Name of the fit."""
    settings: dict[str, Any] = Field(default_factory=dict)
    """Settings of the fit."""

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
    """Return the fits in settings, by field."""
    return {name: value for name, value in settings if isinstance(value, FitChoice)}
