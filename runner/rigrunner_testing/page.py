"""The page of all checks, in Markdown: `python -m rigrunner_testing.page`."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

from rigrunner.registry import load_registry
from rigrunner_testing import making, settings
from rigrunner_testing.brought import conformance
from rigrunner_testing.kinds import OF_KIND

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from rigrunner_testing.check import AnyCheck

HEAD = """\
# Conformance checks

The requirements for plugins. [`rigrunner check-plugin`](help.md#rigrunner-check-plugin-name) makes
these checks; in [the tests of a package](../how-to/check-a-plugin.md) each is a separate test. This
page is made by `python -m rigrunner_testing.page`.

Checks marked \N{BLACK RIGHT-POINTING SMALL TRIANGLE} set the drives of a device: `--read-only`
leaves them out.
"""
MOVES = "\N{BLACK RIGHT-POINTING SMALL TRIANGLE} "


def page() -> str:
    """Return the page."""
    of_kind: dict[str, Iterable[AnyCheck]] = dict(OF_KIND)
    registry = load_registry()
    for kind_record in registry.kinds:
        module = conformance(registry, kind_record.name)
        if module is not None:
            of_kind[kind_record.name] = module.CHECKS
    lines = [HEAD, *_section("Every plugin", (*settings.CHECKS, *making.CHECKS))]
    for kind, checks in of_kind.items():
        lines += _section(f"Plugins of the kind {kind.replace('_', ' ')}", checks)
    return "\n".join(lines)


def _section(title: str, checks: Iterable[AnyCheck]) -> Iterator[str]:
    yield f"## {title}\n"
    yield "| check | requirement | how to fix it |"
    yield "|---|---|---|"
    for check in checks:
        mark = MOVES if check.moves else ""
        yield f"| {mark}`{check.name}` | {_cell(check.holds)} | {_cell(check.fix)} |"
    yield ""


def _cell(text: str) -> str:
    return text.replace("|", "\\|")


if __name__ == "__main__":
    sys.stdout.write(page())
