"""What ends a message, by name or as it is, and the text of one."""

from __future__ import annotations

from typing import Annotated

from pydantic import AfterValidator

NAMES = {
    "LF": "\n",
    "CR": "\r",
    "CRLF": "\r\n",
    "LFCR": "\n\r",
    "NUL": "\0",
    "ETX": "\x03",
    "none": "",
}


def _characters(text: str) -> str:
    if text in NAMES:
        return NAMES[text]
    if text and all(character < " " for character in text):
        return text
    raise ValueError(f"got '{text}', expected one of: {', '.join(NAMES)}")


Termination = Annotated[str, AfterValidator(_characters)]


def termination_name(characters: str) -> str:
    """Return the name of a termination, as a station has it."""
    names = {value: name for name, value in NAMES.items()}
    return names.get(characters, repr(characters))


def decode(raw: bytes) -> str:
    """Return what an instrument sent as text: UTF-8, or else one character a byte."""
    try:
        return raw.decode()
    except UnicodeDecodeError:
        return raw.decode("latin-1")
