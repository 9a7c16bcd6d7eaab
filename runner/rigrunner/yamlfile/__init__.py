"""Strict YAML whose values know their line and column.

What a person may write is a small part of YAML, chosen so that nothing is read as anything but what
it looks like:

- Unquoted `true`, `false`, `null`, `~` and decimal numbers are what YAML 1.2 says they are. All
  other scalars are text: `no`, `off`, `10:30`, `2026-01-05`, `1_000`, `0x1F`. A model that wants a
  yes or no says so (`rigrunner.api.settings.YesNo`) and there reads `yes` and `no` as such.
- Refused, each with its place and a hint: keys that are not text or stand twice, anchors, aliases,
  tags, leading zeros, infinity and not-a-number, more than one document, files that are too large,
  too deep, of too many values, binary, or not UTF-8.
"""

from __future__ import annotations

from rigrunner.yamlfile.document import Document
from rigrunner.yamlfile.reader import parse, read
from rigrunner.yamlfile.validation import validate

__all__ = ["Document", "parse", "read", "validate"]
