"""Reads Markdown pages as scripts: their code blocks in order, with what is said about each.

A comment beside a block says how it is meant:
  <!-- file: NAME --> before it: the block is the content of that file;
  <!-- run by ... --> after it: somebody else runs it, and says so.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parent.parent
_BLOCK = re.compile(
    r"(?:<!-- file: (?P<file>\S+) -->\n)?"
    r"^```(?P<language>\w*)\n(?P<code>.*?)^```$\n?"
    r"(?:<!-- (?P<elsewhere>run by [^>]+) -->)?",
    re.MULTILINE | re.DOTALL,
)


@dataclass(frozen=True)
class CodeBlock:
    """A fenced block of a page."""

    language: str
    code: str
    line: int
    file: str
    elsewhere: str


def code_blocks(page: Path) -> list[CodeBlock]:
    """Return the fenced blocks of a Markdown page, in order."""
    text = page.read_text(encoding="utf-8")
    return [
        CodeBlock(
            match["language"],
            match["code"],
            text.count("\n", 0, match.start("code")),
            match["file"] or "",
            match["elsewhere"] or "",
        )
        for match in _BLOCK.finditer(text)
    ]


def matches(expected: str, output: str) -> bool:
    """Return whether every line of the expected text is a line of the output, in order.

    '…' stands for any characters; other lines may stand between.
    """
    lines = iter(output.splitlines())
    for expected_line in expected.splitlines():
        pattern = ".*".join(re.escape(part) for part in expected_line.rstrip().split("…"))
        if not any(re.fullmatch(pattern, line.rstrip()) for line in lines):
            return False
    return True


def links(page: Path) -> list[str]:
    """Return the targets of all links and images of a page that lead to files here."""
    text = re.sub(
        r"^```.*?^```$", "", page.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL
    )
    targets = re.findall(r"\]\(([^)\s]+)\)", text)
    return [target for target in targets if not re.match(r"https?:|mailto:|#", target)]


def pages() -> list[Path]:
    """Return every Markdown page of the project."""
    return [*sorted(ROOT.glob("*.md")), *sorted(ROOT.glob("docs/**/*.md"))]
