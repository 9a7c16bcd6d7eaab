"""A lab folder: everything of one rig that is a laboratory's own, ready to run."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

from rigrunner.registry import with_drop_ins
from rigrunner.run.locate import find_procedure
from rigrunner.tools.new_files import write_new_files
from rigrunner.tools.schemas.files import language_schema

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigrunner.registry import Registry
    from rigrunner.tools.schemas.files import Language

TEMPLATE = Path(__file__).parent / "lab_template"
STATION = "station.yaml"
PROCEDURES = ("no_load_inertia_sweep", "starting_torque_1000n")
"""Those that ship and a new folder has, in the order to run them."""
_UNDER_ANOTHER_NAME = {"gitignore": ".gitignore", "gitattributes": ".gitattributes"}
"""Files that would have an effect where the template lies."""
_SCHEMAS: dict[str, Language] = {
    "procedures/procedure.schema.json": "procedure",
    "station.schema.json": "station",
    "letterhead/letterhead.schema.json": "letterhead",
    "reports/order.schema.json": "order",
}


def make_lab(folder: Path, registry: Registry) -> list[str]:
    """Write a lab folder and return the procedures in it, in the order to run them.

    Nothing that is there is changed: raises UsageError if a file of that name exists, before any
    is written, and if one cannot be written.
    """
    texts = _texts(registry)
    write_new_files(folder, texts)
    return [name for name in texts if name.startswith("procedures/") and name.endswith(".yaml")]


def _texts(registry: Registry) -> Mapping[str, str]:
    """Return what the folder holds: texts by name."""
    copied = {f"procedures/{name}.yaml": find_procedure(name) for name in PROCEDURES}
    own = {_name(path): path for path in sorted(TEMPLATE.rglob("*")) if _is_content(path)}
    texts = {name: path.read_text(encoding="utf-8") for name, path in (copied | own).items()}
    with_own = with_drop_ins(registry, TEMPLATE / "plugins")
    schemas = {name: language_schema(language, with_own) for name, language in _SCHEMAS.items()}
    return texts | {
        name: json.dumps(schema, indent=2, ensure_ascii=False) + "\n"
        for name, schema in schemas.items()
    }


def _is_content(path: Path) -> bool:
    return path.is_file() and "__pycache__" not in path.parts


def _name(path: Path) -> str:
    name = path.relative_to(TEMPLATE).as_posix()
    return _UNDER_ANOTHER_NAME.get(name, name)
