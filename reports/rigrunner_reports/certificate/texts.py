"""The fixed texts of certificates: shipped languages, and what a laboratory puts before them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from string import Formatter
from typing import TYPE_CHECKING

import yaml

from rigrunner.api import Location
from rigrunner.api.errors import InvalidFileError, Problem, did_you_mean

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

REFERENCE = "en"
"""The language that has every key."""
_MOST = 8
_FOLDER = files("rigrunner_reports") / "certificate" / "texts"


@dataclass(frozen=True)
class Texts:
    """The texts of one language by key."""

    language: str
    by_key: Mapping[str, str]

    def __call__(self, key: str, **values: object) -> str:
        """Return a text with its {names} filled in; raise KeyError if there is no such key."""
        return self.by_key[key].format(**values)

    def or_else(self, key: str, other: str) -> str:
        """Return a text, or another where there is no such key."""
        return self.by_key.get(key, other)


@cache
def shipped(language: str) -> Mapping[str, str]:
    """Return the shipped texts of a language; none where it is not shipped."""
    file = _FOLDER / f"{language}.yaml"
    if not file.is_file():
        return {}
    content = yaml.safe_load(file.read_text(encoding="utf-8"))
    return dict(content["texts"])


def shipped_languages() -> list[str]:
    """Return the languages that are shipped."""
    names = (file.name for file in _FOLDER.iterdir())
    return sorted(name.removesuffix(".yaml") for name in names if name.endswith(".yaml"))


def texts(language: str, own: Mapping[str, Mapping[str, str]]) -> Texts:
    """Return the texts of a language, a laboratory's own before the shipped ones.

    Raises InvalidFileError with everything that is wrong or missing in the laboratory's own.
    """
    given = own.get(language, {})
    found = {**shipped(language), **given}
    problems = list(_problems(language, found, given, [*own]))
    if problems:
        raise InvalidFileError(problems)
    return Texts(language, found)


def _problems(
    language: str, found: Mapping[str, str], given: Mapping[str, str], own: list[str]
) -> Iterator[Problem]:
    reference = shipped(REFERENCE)
    file = Location(f"texts/{language}.yaml")
    missing = [key for key in reference if not found.get(key, "").strip()]
    if len(missing) == len(reference):
        known = ", ".join(sorted({*shipped_languages(), *own}))
        hint = f"there are: {known}; another needs a file texts/{language}.yaml in the letterhead"
        yield Problem(f"there are no texts in the language '{language}'", hint=hint)
        return
    if missing:
        more = f" and {len(missing) - _MOST} more" if len(missing) > _MOST else ""
        names = ", ".join(f"'{key}'" for key in missing[:_MOST])
        hint = "each text is needed, or a certificate would have a blank in its place"
        yield Problem(f"there is no text for {names}{more}", file, "texts", hint)
    for key, text in given.items():
        yield from _problems_of(key, text, reference, file)


def _problems_of(
    key: str, text: str, reference: Mapping[str, str], file: Location
) -> Iterator[Problem]:
    if key not in reference:
        hint = did_you_mean(key, reference)
        yield Problem("there is no such text", file, f"texts.{key}", hint)
        return
    try:
        same = names(text) == names(reference[key])
    except ValueError as error:
        yield Problem(f"{error}", file, f"texts.{key}", "a brace in a text is written twice")
        return
    if not same:
        wanted = ", ".join(f"{{{name}}}" for name in sorted(names(reference[key]))) or "none"
        yield Problem(f"needed in this text: {wanted}", file, f"texts.{key}")


def names(text: str) -> set[str]:
    """Return the {names} in a text; raise ValueError if its braces are wrong."""
    found = {name for _, name, _, _ in Formatter().parse(text) if name is not None}
    wrong = [name for name in found if not name.isidentifier()]
    if wrong:
        raise ValueError(f"'{{{wrong[0]}}}' is no name")
    return found
