"""Words of the guardian to whoever is at the terminal of the run."""

from __future__ import annotations

import os
from contextlib import suppress


def say(text: str) -> None:
    """Write a line to stderr past its buffer; to nobody, if the terminal was closed."""
    with suppress(OSError):
        os.write(2, f"\nguardian: {text}\n".encode())
