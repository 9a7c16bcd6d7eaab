"""Checks that the installed methods are those that a document was calculated with."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from rigrunner.analysis.revisions import FIRST, OWN, methods_of
from rigrunner.api.errors import PluginError
from rigrunner.certificate.content import REVISION
from rigrunner.run.provenance import PROVIDERS

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

    from rigrunner.procedure import Acceptance, Procedure
    from rigrunner.registry import Registry


CERTIFICATE = "certificate"
"""Name of the revision of the content of a certificate."""


def methods_used(
    procedure: Procedure, registry: Registry, acceptance: Acceptance | None = None
) -> tuple[str, ...]:
    """Return the methods that calculate a run of a procedure, by name."""
    return methods_of(procedure.analysis, acceptance or procedure.acceptance, registry)


def other_revisions(
    methods: Iterable[str],
    recorded: Mapping[str, int],
    software: Mapping[str, str],
    registry: Registry,
) -> Iterator[str]:
    """Yield methods that are installed in another revision than recorded, or not at all.

    `software` are the recorded versions, which reproduce the recorded numbers.
    """
    # Where an analysis is not installed, its settings do not tell which fits it used.
    fits = (name for name in recorded if name.startswith("fit "))
    for method in dict.fromkeys((*methods, *fits)):
        then, now = recorded.get(method, FIRST), _installed(method, registry)
        if then != now:
            kind, _, name = method.partition(" ")
            what = f"{kind.replace('_', ' ')} '{name}'" if name else kind
            installed = "not installed" if now is None else f"installed {now}"
            program = made_with(software, kind, name, registry)
            yield f"{what} revision {then}, {installed}; {program} recomputes them"


def _installed(method: str, registry: Registry) -> int | None:
    if method == CERTIFICATE:
        return REVISION
    if method in OWN:
        return OWN[method]
    kind, _, name = method.partition(" ")
    try:
        return registry.revision(kind, name)
    except PluginError:
        return None


def made_with(software: Mapping[str, str], kind: str, name: str, registry: Registry) -> str:
    """Return name and version of the provider of a method at that time, such as 'version 0.1.0'.

    It is found in the recorded versions by the name of the present provider.
    """
    version = f"version {software.get('Rigrunner', 'unknown')}"
    try:
        provider = registry.find(kind, name).provider.name
    except PluginError:
        provider = ""
    if not name:
        return version
    providers = software.get(PROVIDERS, "")
    match = re.search(rf"(?:^|, )({re.escape(provider)} [^,]+)", providers) if provider else None
    if match:
        return f"version {match[1].removeprefix(provider).strip()} of {provider}"
    return f"what was installed then ({providers or version})"
