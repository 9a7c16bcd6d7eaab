"""The plugin API of a provider, and whether this Rigrunner supports it."""

from __future__ import annotations

import re

from rigrunner import __version__
from rigrunner.api.errors import PluginError
from rigrunner.api.hooks import API_VERSION, OLDEST_API_VERSION

_IN_TEXT = re.compile(r"^api_version\b[^=\n]*=\s*(\d+)\s*(?:#.*)?$", re.MULTILINE)


def check_api_version(declared: object) -> None:
    """Raise PluginError unless this Rigrunner supports the API."""
    if not isinstance(declared, int) or isinstance(declared, bool):
        raise PluginError(
            "it does not say for which plugin API it is made",
            hint=f"its module needs a line 'api_version = {API_VERSION}'",
        )
    made = f"it is made for plugin API {declared}, and Rigrunner {__version__} has {_offered()}"
    if declared > API_VERSION:
        raise PluginError(
            made,
            hint=f"update Rigrunner, or install a version of it for API {API_VERSION}",
        )
    if declared < OLDEST_API_VERSION:
        raise PluginError(
            made,
            hint=f"install a newer version of it, for API {_offered()}, or an older Rigrunner",
        )


def version_in(text: str) -> int | None:
    """Return the API version declared in the text of a module; for one that cannot be imported."""
    found = _IN_TEXT.search(text)
    return int(found[1]) if found else None


def _offered() -> str:
    if OLDEST_API_VERSION == API_VERSION:
        return str(API_VERSION)
    return f"{OLDEST_API_VERSION} to {API_VERSION}"
