"""The fixed texts of certificates: shipped languages, and a laboratory's own."""

from __future__ import annotations

import re
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
    from importlib.resources.abc import Traversable

REFERENCE = "en"
"""The language that has every key."""
_MOST = 8
_FOLDER = files("rigrunner_reports") / "certificate" / "texts"


@dataclass(frozen=True)
class Texts:
    """The texts of one language by key."""

    language: str
    by_key: Mapping[str, str]
    said: Said
    """Sentences that runs record in English."""

    def __call__(self, key: str, **values: object) -> str:
        """Return a text with its {names} filled in; raise KeyError if there is no such key."""
        return self.by_key[key].format(**values)

    def or_else(self, key: str, other: str) -> str:
        """Return a text, or another one if there is no such key."""
        return self.by_key.get(key, other)


@dataclass(frozen=True)
class Said:
    """Recorded English sentences in another language, by patterns with {names}.

    {number} and {value} (a number with its unit) match only these, {said} matches a sentence, any
    other name any text.
    """

    sentences: tuple[tuple[re.Pattern[str], str], ...] = ()

    def __call__(self, text: str) -> str:
        """Return a sentence, or several with '; ' between, translated; unchanged if unknown."""
        sentence = self._translated(text)
        if sentence is not None:
            return sentence
        parts = text.split("; ")
        return "; ".join(self._translated(part) or part for part in parts)

    def _translated(self, text: str) -> str | None:
        for pattern, translation in self.sentences:
            if match := pattern.fullmatch(text):
                values = {
                    name: self(part) if name.startswith("said") else part
                    for name, part in match.groupdict().items()
                }
                return translation.format(**values)
        return None


_NUMBER = r"[+\u2212-]?\d[\d.]*(?:e[+-]?\d+)?"
_KINDS = {"number": _NUMBER, "value": rf"{_NUMBER}(?: \S+?)?", "said": ".+"}
_OTHERS = "(?:(?!; ).)+?"


def _shape(english: str) -> str:
    parts = re.split(r"\{([a-z]+)(\d*)\}", english)
    shape = re.escape(parts[0])
    for kind, place, literal in zip(parts[1::3], parts[2::3], parts[3::3], strict=True):
        shape += f"(?P<{kind}{place}>{_KINDS.get(kind, _OTHERS)}){re.escape(literal)}"
    return shape


@cache
def shipped(language: str) -> Mapping[str, str]:
    """Return the shipped texts of a language, or none."""
    file = _FOLDER / f"{language}.yaml"
    if not file.is_file():
        return {}
    return dict(_content(file)["texts"])


@cache
def said(language: str) -> Said:
    """Return the sentences of runs in a shipped language; none in others, or in English."""
    file = _FOLDER / f"{language}.yaml"
    if not file.is_file():
        return Said()
    sentences = _content(file).get("said", {})
    # Those with the most literal text come first.
    fixed = sorted(sentences, key=lambda english: -len(re.sub(r"\{\w+\}", "", english)))
    return Said(tuple((re.compile(_shape(english)), sentences[english]) for english in fixed))


def _content(file: Traversable) -> dict[str, dict[str, str]]:
    return dict(yaml.safe_load(file.read_text(encoding="utf-8")))


def shipped_languages() -> list[str]:
    """Return the shipped languages."""
    names = (file.name for file in _FOLDER.iterdir())
    return sorted(name.removesuffix(".yaml") for name in names if name.endswith(".yaml"))


def texts(language: str, own: Mapping[str, Mapping[str, str]]) -> Texts:
    """Return the texts of a language; a laboratory's own take precedence.

    Raises InvalidFileError with all errors in the laboratory's own.
    """
    own_texts = own.get(language, {})
    merged = {**shipped(language), **own_texts}
    problems = list(_problems(language, merged, own_texts, [*own]))
    if problems:
        raise InvalidFileError(problems)
    return Texts(language, merged, said(language))


def _problems(
    language: str, merged: Mapping[str, str], own_texts: Mapping[str, str], languages: list[str]
) -> Iterator[Problem]:
    reference = shipped(REFERENCE)
    file = Location(f"texts/{language}.yaml")
    missing = [key for key in reference if not merged.get(key, "").strip()]
    if len(missing) == len(reference):
        known = ", ".join(sorted({*shipped_languages(), *languages}))
        hint = f"there are: {known}; another needs a file texts/{language}.yaml in the letterhead"
        yield Problem(f"there are no texts in the language '{language}'", hint=hint)
        return
    if missing:
        more = f" and {len(missing) - _MOST} more" if len(missing) > _MOST else ""
        names = ", ".join(f"'{key}'" for key in missing[:_MOST])
        hint = "each text is needed, or a certificate would have a blank in its place"
        yield Problem(f"there is no text for {names}{more}", file, "texts", hint)
    for key, text in own_texts.items():
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
        needed = ", ".join(f"{{{name}}}" for name in sorted(names(reference[key]))) or "none"
        yield Problem(f"needed in this text: {needed}", file, f"texts.{key}")


def names(text: str) -> set[str]:
    """Return the {names} in a text; raise ValueError if its braces are wrong."""
    fields = {name for _, name, _, _ in Formatter().parse(text) if name is not None}
    wrong = [name for name in fields if not name.isidentifier()]
    if wrong:
        raise ValueError(f"'{{{wrong[0]}}}' is not a name")
    return fields
