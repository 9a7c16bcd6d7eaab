"""Checks of objects from plugins before use: a defect is a PluginError that names the plugin.

Packages with their own kinds of plugins can use these checks too.
"""

from __future__ import annotations

import math
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, NoReturn

import numpy as np

from rigrunner.api.errors import PluginError, RigrunnerError
from rigrunner.api.texts import clip

if TYPE_CHECKING:
    from collections.abc import Iterator

_LONGEST = 80
"""Characters of a value in a message."""


@dataclass(frozen=True)
class Subject:
    """The plugin under scrutiny."""

    kind: str
    name: str

    @contextmanager
    def named(self) -> Iterator[None]:
        """Add the name of the plugin to unexpected exceptions, as a note."""
        try:
            yield
        except RigrunnerError:
            raise
        except Exception as error:
            if not getattr(error, "__notes__", None):  # a plugin that it called was named already
                error.add_note(f"in the {self.kind.replace('_', ' ')} '{self.name}'")
            raise

    def refuse(self, what: str) -> NoReturn:
        """Raise the PluginError."""
        kind = self.kind.replace("_", " ")
        hint = f"report it to its author; see 'rigrunner check-plugin {self.name}'"
        raise PluginError(f"the {kind} '{self.name}' gave {what}", hint=hint)

    def need(self, holds: bool, what: str) -> None:  # noqa: FBT001  (reads as a sentence)
        """Raise the PluginError unless the condition is true."""
        if not holds:
            self.refuse(what)


def protect(*arrays: object) -> None:
    """Make shared arrays read-only."""
    for array in arrays:
        if isinstance(array, np.ndarray):
            array.flags.writeable = False


def are_numbers(values: object, shape: tuple[int, ...]) -> bool:
    """Return whether values are finite numbers of a shape."""
    array = np.asarray(values)
    return array.shape == shape and array.dtype.kind in "fiu" and bool(np.isfinite(array).all())


def is_real(value: object) -> bool:
    """Return whether a value is a number, including nan and infinity."""
    return isinstance(value, (float, int, np.floating, np.integer)) and not isinstance(value, bool)


def is_finite(value: object) -> bool:
    """Return whether a value is a finite number."""
    return is_real(value) and math.isfinite(value)  # type: ignore[arg-type]  # a number


def shown(value: object) -> str:
    """Return a value as text for a message, shortened if long."""
    text = " ".join(repr(value).split())
    return clip(text, _LONGEST)
