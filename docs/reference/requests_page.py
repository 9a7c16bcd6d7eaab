#!/usr/bin/env python3
"""Lists the requests of the panel's API, from the table that serves them.

python docs/reference/requests_page.py docs/reference
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

from rigrunner_panel.view.sections import State
from rigrunner_panel.web.operations import OPERATIONS

if TYPE_CHECKING:
    from collections.abc import Iterable

    from pydantic import BaseModel

    from rigrunner_panel.web.operation import Operation

HEAD = """# Requests of the panel's API

Made by `docs/reference/requests_page.py`. [The panel's HTTP API](panel-api.md) explains access,
errors and the state. *Control* marks requests that only the client in control may make. The types
of all fields are in `/api/v1/openapi.json`.

| request | control | takes | answers | what it does |
|---|---|---|---|---|
"""
STATE = "[the state](panel-api.md#the-state)"


def page() -> str:
    """Return the whole page."""
    return HEAD + "".join(map(_row, OPERATIONS))


def _row(each: Operation) -> str:
    takes = [*each.query, *(each.body.model_fields if each.body else ())]
    cells = [
        f"`{each.method} {each.path}`",
        "control" if each.steers else "",
        _names(takes),
        _answer(each.answer),
        each.summary,
    ]
    return f"| {' | '.join(cells)} |\n"


def _answer(model: type[BaseModel] | None) -> str:
    if model is None:
        return "the file"
    return STATE if model is State else _names(model.model_fields)


def _names(fields: Iterable[str]) -> str:
    return ", ".join(f"`{name}`" for name in fields)


def main(folder: Path) -> None:
    """Write the page."""
    (folder / "panel-requests.md").write_text(page(), encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
