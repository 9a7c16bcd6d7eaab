"""The installation: Python, the packages that Rigrunner needs, and the plugins."""

from __future__ import annotations

import platform
import re
import sys
from collections import Counter
from importlib.metadata import PackageNotFoundError, requires, version
from typing import TYPE_CHECKING

from rigrunner import __version__
from rigrunner.tools.doctor.finding import Finding, State, Surroundings

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigrunner.registry import Registry

OLDEST_PYTHON = (3, 11)


def python(_: Surroundings) -> Iterator[Finding]:
    """Compare Python with the oldest supported version."""
    oldest = ".".join(map(str, OLDEST_PYTHON))
    fit = sys.version_info[:2] >= OLDEST_PYTHON
    found = f"{platform.python_implementation()} {platform.python_version()} at {sys.executable}"
    fix = "" if fit else f"install Python {oldest} or newer"
    yield Finding("Python", "ok" if fit else "fail", found, fix)


def packages(_: Surroundings) -> Iterator[Finding]:
    """Compare what is installed with the lower bounds in the package's metadata."""
    needed = [line for line in requires("rigrunner") or () if "extra ==" not in line]
    found = []
    for line in needed:
        name, least = line.replace(" ", "").split(">=")
        try:
            installed = version(name)
        except PackageNotFoundError:
            yield Finding("packages", "fail", f"{name} is missing", f"pip install '{line}'")
            continue
        if numbers(installed) < numbers(least):
            text = f"{name} {installed} is too old"
            yield Finding("packages", "fail", text, f"pip install '{line}'")
        found.append(f"{name} {installed}")
    yield Finding("packages", "ok", f"rigrunner {__version__}, {', '.join(found)}")


def numbers(text: str) -> tuple[int, ...]:
    """Return the numbers of a version, of which the first three count."""
    return tuple(int(part) for part in re.findall(r"\d+", text.partition("+")[0])[:3])


def plugins(of: Surroundings) -> Iterator[Finding]:
    """Count the plugins by provider; report disabled ones, and names used twice."""
    count = Counter(str(plugin.provider) for plugin in of.registry.plugins)
    listing = ", ".join(f"{number} of {provider}" for provider, number in sorted(count.items()))
    state: State = "ok" if count else "fail"
    yield Finding("plugins", state, listing or "none", "" if count else "reinstall Rigrunner")
    for disabled in of.registry.disabled:
        fix = "fix or uninstall it; its plugins are not available"
        text = f"{disabled.provider} is disabled: {disabled.reason}"
        yield Finding("plugins", "warn", text, fix)
    yield from _claimed_twice(of.registry)


def _claimed_twice(registry: Registry) -> Iterator[Finding]:
    claims: dict[tuple[str, str], list[str]] = {}
    for plugin in registry.plugins:
        providers = claims.setdefault((plugin.kind, plugin.record.name), [])
        providers.append(str(plugin.provider))
    for (kind, name), providers in claims.items():
        if len(providers) > 1:
            text = f"{kind.replace('_', ' ')} '{name}' is provided by {' and '.join(providers)}"
            yield Finding("plugins", "warn", text, "uninstall one of them; neither can be used")
