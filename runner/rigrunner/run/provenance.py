"""How a run was made: versions of program, packages and plugins, and identities of devices."""

from __future__ import annotations

import hashlib
import platform
from importlib.metadata import entry_points, version
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

from rigrunner import __version__
from rigrunner.api.errors import DataError
from rigrunner.api.hooks import UnitRecord
from rigrunner.runfile.added_units import unit_texts

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigrunner.api.devices import Identity
    from rigrunner.registry import Registry

PROJECT = "rigrunner"
"""The package, and the group of the entry points of its plugins."""

PROVIDERS = "plugin providers"
"""Key of the providers of plugins, each with its version or digest."""
SIMULATED = " (simulated)"
PACKAGES = ("numpy", "scipy", "h5py", "pydantic", "pyyaml", "pluggy")


def software(registry: Registry) -> dict[str, str]:
    """Return the versions of everything that affects the numbers, by name."""
    providers = {str(plugin.provider) for plugin in registry.plugins}
    packages = {name: version(name) for name in PACKAGES}
    return {
        "Rigrunner": __version__,
        "Python": platform.python_version(),
        **packages,
        PROVIDERS: ", ".join(sorted(providers)),
        **unit_texts(
            plugin.record.definition
            for plugin in registry.plugins
            if isinstance(plugin.record, UnitRecord)
        ),
    }


def layouts(registry: Registry) -> dict[str, int]:
    """Return the revision of the layout of each printed form of a certificate, by name."""
    kind = "certificate_format"
    return {name: registry.revision(kind, name) for name in registry.names(kind)}


def refuse_other_software(expected: Mapping[str, str], registry: Registry) -> None:
    """Raise DataError on a worker whose `software` differs from that of its caller."""
    local_software = software(registry)
    for name, text in expected.items():
        if local_software.get(name) != text:
            raise DataError(
                f"a worker of the cluster has {name} {local_software.get(name)}, not {text}",
                hint="other versions find other numbers: install the same on every machine",
            )


def code_digest(*lab_folders: Path) -> str:
    """Return a digest of the installed code of program and plugins.

    `lab_folders` have plugins of a lab. The digest covers paths, sizes and times of files:
    the same code elsewhere may have another one.
    """
    names = {entry.module.split(".")[0] for entry in entry_points(group=PROJECT)} | {PROJECT}
    specs = filter(None, map(find_spec, names))
    installed = {Path(folder) for spec in specs for folder in spec.submodule_search_locations or ()}
    digest = hashlib.sha256()
    for folder in sorted({*installed, *lab_folders}):
        for file in sorted(folder.rglob("*.py")):
            status = file.stat()
            digest.update(f"{file} {status.st_size} {status.st_mtime_ns}\n".encode())
    return digest.hexdigest()[:16]


def identities(by_role: Mapping[str, Identity]) -> dict[str, str]:
    """Return the identities at each role and part, 'role/part', as text."""
    texts: dict[str, str] = {}
    for role, identity in by_role.items():
        fields = (identity.maker, identity.model, identity.serial, identity.firmware)
        simulated = SIMULATED if identity.simulated else ""
        texts[f"device {role}"] = " ".join(filter(None, fields)) + simulated
        texts |= identities({f"{role}/{name}": part for name, part in identity.parts.items()})
    return texts


def is_simulated(provenance: Mapping[str, str]) -> bool:
    """Return whether an identity is that of a simulator, or of a device with injected faults."""
    return any(
        name.startswith("device ") and text.endswith(SIMULATED) for name, text in provenance.items()
    )
