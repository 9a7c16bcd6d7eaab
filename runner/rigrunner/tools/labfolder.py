"""Make a lab folder: all files of a laboratory for one rig, ready to run."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

from rigrunner.api.errors import UsageError
from rigrunner.api.hooks import LabRecord
from rigrunner.registry import with_drop_ins
from rigrunner.run.locate import find_procedure
from rigrunner.tools.new_files import write_new_files
from rigrunner.tools.schemas.files import language_schema

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigrunner.registry import Registry
    from rigrunner.tools.schemas.files import Language

TEMPLATE = Path(__file__).parent / "lab_template"
"""Files of every lab."""
STATION, PLUGINS = "station.yaml", "plugins"
_REAL_NAMES = {"gitignore": ".gitignore", "gitattributes": ".gitattributes"}
"""Files that git would obey in the folder of the templates, by their name there."""
_SCHEMAS: dict[str, Language] = {
    "procedures/procedure.schema.json": "procedure",
    "station.schema.json": "station",
    "letterhead/letterhead.schema.json": "letterhead",
    "reports/order.schema.json": "order",
}


def make_lab(folder: Path, registry: Registry, name: str = "") -> list[str]:
    """Write a lab folder and return its procedures, in the order to run them.

    `name` is that of a plugin of the kind 'lab'; it is optional if there is only one. No existing
    file is changed: raises UsageError if a file of that name exists, before any is written, and if
    one cannot be written.
    """
    if not name:
        names = registry.names("lab")
        if len(names) != 1:
            raise UsageError(
                f"got no lab template, expected one of: {', '.join(names) or 'none is installed'}",
                hint="name it with --lab" if names else "install a package that provides one",
            )
        (name,) = names
    files = write_new_files(folder, _texts(registry, name))
    return [name for name in files if name.startswith("procedures/") and name.endswith(".yaml")]


def _texts(registry: Registry, lab: str) -> Mapping[str, str]:
    """Return the files of the folder: texts by name."""
    record, files = registry.find("lab", lab).record, registry.make("lab", lab, {})
    assert isinstance(record, LabRecord)  # noqa: S101  (the kind says so)
    copied = {f"procedures/{name}.yaml": find_procedure(name) for name in record.procedures}
    template_files = {
        path.relative_to(folder).as_posix(): path
        for folder in (TEMPLATE, files)
        for path in sorted(folder.rglob("*"))
        if path.is_file() and "__pycache__" not in path.parts
    }
    texts: dict[str, str] = {
        _REAL_NAMES.get(name) or name: path.read_text(encoding="utf-8")
        for name, path in (copied | template_files).items()
    }
    has_plugins = (files / PLUGINS).is_dir()
    with_plugins = with_drop_ins(registry, files / PLUGINS) if has_plugins else registry
    schemas = {name: language_schema(language, with_plugins) for name, language in _SCHEMAS.items()}
    return texts | {
        name: json.dumps(schema, indent=2, ensure_ascii=False) + "\n"
        for name, schema in schemas.items()
    }
