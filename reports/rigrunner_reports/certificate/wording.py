"""The facts of a certificate in a language: numbers, dates, verdicts, rules."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING

from rigrunner.api.findings import Formula
from rigrunner.api.units import with_symbol
from rigrunner.api.verdict import CERTAIN
from rigrunner_reports.mathematics import equation
from rigrunner_reports.numbers import MANY_DOF, MINUS, fixed, plain, significant
from rigrunner_reports.view.decision import SYMBOLS

if TYPE_CHECKING:
    from collections.abc import Mapping

    from markupsafe import Markup

    from rigrunner.api.certificate import (
        BudgetLine,
        Certificate,
        Equation,
        InstrumentEntry,
        LimitStatement,
        MeasurementModel,
        Method,
        NamedResult,
        PointResult,
        StatedResult,
        ValidityCondition,
    )
    from rigrunner_reports.certificate.texts import Texts

SYMBOL_OF = {str(verdict): symbol for verdict, symbol in SYMBOLS.items()}
_POINT = re.compile(r"(?<=\d)\.(?=\d)")
_NEGATIVE = re.compile(r"(?<![\w.])-(?=\d)")


@dataclass(frozen=True)
class Wording:
    """Writes facts with the texts of one language."""

    texts: Texts

    def number(self, printed: str) -> str:
        """Return a printed number, or a text with numbers, with the language's decimal sign."""
        with_minus = _NEGATIVE.sub(MINUS, printed)
        return _POINT.sub(self.texts("decimal"), with_minus)

    def said(self, recorded: str) -> str:
        """Return a recorded sentence in this language, if it is known."""
        translated = self.texts.said(recorded)
        return self.number(translated) if translated != recorded else recorded

    def reason(self, stated: LimitStatement) -> str:
        """Return why a limit has its verdict, in this language, or as recorded if it is not known.

        The record begins with what the limit applies to. That is English, and on the page already.
        """
        of, named = re.escape(stated.of), re.escape(stated.named)
        beginning = re.match(f"(?:At |The |{named}, )?{of}: ", stated.reason, re.IGNORECASE)
        sentence = stated.reason[beginning.end() :] if beginning else stated.reason
        sentence = f"{sentence[:1].upper()}{sentence[1:]}"
        translated = self.said(sentence)
        return stated.reason if translated == sentence else translated

    def plain(self, value: float) -> str:
        """Return a set value as it was written."""
        return self.number(plain(value))

    def load(self, newtons: float) -> str:
        """Return a load with four significant digits."""
        return self.number(significant(newtons))

    def figures(self, value: float | None) -> str:
        """Return a number of a budget with three significant digits; '' for none."""
        return "" if value is None else self.number(significant(value, 3))

    def equation(self, stated: Equation) -> Markup:
        """Return an equation as MathML."""
        formula = Formula(symbol=stated.symbol, text=stated.text, quantities=stated.quantities)
        return equation(formula)

    def model_of(self, certificate: Certificate, model: MeasurementModel) -> NamedResult:
        """Return the value that a model computes, which has the budget."""
        return next(
            result
            for result in certificate.named
            if (result.name, result.coordinates) == (model.name, model.coordinates)
        )

    def shares(self, model: MeasurementModel) -> list[tuple[BudgetLine, str]]:
        """Return the lines of a budget, each with its share of the variance."""
        total = sum(line.contribution**2 for line in model.budget)
        return [
            (line, self.number(fixed(100 * line.contribution**2 / total, 1)) if total else "")
            for line in model.budget
        ]

    def day(self, utc: str) -> str:
        """Return the date of a time in ISO 8601, which is the same in every language."""
        return utc[:10]

    def moment(self, utc: str) -> str:
        """Return a time to the second."""
        return f"{utc[:19].replace('T', ' ')} UTC"

    def period(self, start_utc: str, end_utc: str) -> str:
        """Return a period of time."""
        start, end = (self.moment(utc) for utc in (start_utc, end_utc))
        return self.texts("tested.period", start=start, end=end)

    def interval(self, result: StatedResult) -> str:
        """Return value, expanded uncertainty and unit."""
        value, u = self.number(result.printed), self.number(result.printed_uncertainty)
        return with_symbol(f"({value} ± {u})", result.unit)

    def dof(self, result: StatedResult) -> str:
        """Return effective degrees of freedom, rounded downwards as in GUM G.4.1."""
        dof = result.degrees_of_freedom
        return self.texts("infinite") if dof is None or dof > MANY_DOF else f"{int(dof)}"

    def percent(self, probability: float) -> str:
        """Return a probability in per cent, with at most two decimals; '< 0.01' for less."""
        if probability < 1 - CERTAIN:
            return self.number("< 0.01")
        return self.number(f"{100 * probability:.2f}".rstrip("0").rstrip("."))

    def verdict(self, verdict: str) -> str:
        """Return a verdict as text."""
        return self.texts.or_else(f"verdict.{verdict}", verdict)

    def symbol(self, verdict: str) -> str:
        """Return the symbol of a verdict."""
        return SYMBOL_OF.get(verdict, "?")

    def tone(self, verdict: str) -> str:
        """Return a verdict as a CSS class."""
        return verdict.replace(" ", "-") if verdict in SYMBOL_OF else "inconclusive"

    def rule(self, name: str, words: str, words_in: Mapping[str, str] | None = None) -> str:
        """Return a decision rule as text: of the language's texts, or else the rule's own.

        `words` are in English, `words_in` in other languages by their names.
        """
        default = (words_in or {}).get(self.texts.language, words or name)
        return self.texts.or_else(f"rule.{name}", default)

    def rule_name(self, rule: str) -> str:
        """Return the name of a decision rule that is recorded as 'name: words'."""
        return rule.partition(":")[0]

    def judged(self, stated: LimitStatement) -> str:
        """Return the result that a limit applies to; without its place, see `place`."""
        if stated.of == f"mean {stated.named}":
            return self.texts("conformity.of.mean_of", name=stated.named)
        if stated.of.startswith("worst ") and stated.named:
            return self.texts("conformity.of.worst_of", name=stated.named)
        if stated.coordinates:
            return stated.named
        return self.texts.or_else(f"conformity.of.{stated.of}", self.number(stated.of))

    def limit(self, stated: str) -> str:
        """Return a limit such as '≤ 0.95 N·m' or '-0.3 K to 0.3 K', as recorded in English."""
        return self.number(stated).replace(" to ", f" {self.texts('conformity.until')} ")

    def place(self, stated: LimitStatement) -> str:
        """Return the coordinates of the result that a limit applies to."""
        places = (f"{name} = {at.printed}" for name, at in stated.coordinates.items())
        return self.number(", ".join(places))

    def quantity(self, name: str) -> str:
        """Return the name of a condition."""
        return self.texts.or_else(f"quantity.{name}", name)

    def accuracy(self, entry: InstrumentEntry) -> list[str]:
        """Return the limits of error, one a line."""
        return [
            f"{self.texts.or_else(f'accuracy.{part}', part)} {self.number(value)}"
            for part, value in entry.uncertainty.items()
        ]

    def validity(self, condition: ValidityCondition) -> str:
        """Return a condition of validity as text; for an unknown one its code."""
        text = self.texts.or_else(f"validity.{condition.code}", condition.code)
        allowed = self.number(condition.allowance)
        return f"{text} ({allowed})" if allowed else text

    def load_instruments(self, certificate: Certificate) -> list[InstrumentEntry]:
        """Return the instruments that measured the load."""
        return [entry for entry in certificate.instruments if entry.channel.endswith(".load")]

    def used(self, point: PointResult) -> str:
        """Return the number of cycles in a mean, of all."""
        used = point.cycles - point.cycles_rejected
        return self.texts("points.cycles.of", used=used, all=point.cycles)

    def deciding(self, certificate: Certificate) -> NamedResult:
        """Return the named result on which the verdict rests, or else the first one."""
        named = certificate.named
        if certificate.conformity is None:
            return named[0]
        first = certificate.conformity.statements[0]
        places = {
            f"{result.name} at {place}" if place else result.name: result
            for result in named
            for place in [
                ", ".join(f"{name} = {at.printed}" for name, at in result.coordinates.items())
            ]
        }
        same = (result for result in named if result.name == first.named)
        return places.get(first.of.removeprefix("worst "), next(same, named[0]))

    def by_name(self, certificate: Certificate) -> list[tuple[str, list[NamedResult]]]:
        """Return the named results, those of one name together."""
        by_name: dict[str, list[NamedResult]] = {}
        for result in certificate.named:
            by_name.setdefault(result.name, []).append(result)
        return [*by_name.items()]

    def entered(self, certificate: Certificate) -> list[tuple[str, str]]:
        """Return the inputs of the run that are not stated elsewhere."""
        stated = {certificate.item.identification, certificate.performance.operator}
        inputs = certificate.performance.inputs
        return [(self.said(name), value) for name, value in inputs.items() if value not in stated]

    def digests(self, method: Method) -> list[tuple[str, str]]:
        """Return the digests of the procedure and of those that it calls."""
        called = (
            (self.texts("method.called", file=file), sha256)
            for file, sha256 in method.called.items()
        )
        return [(self.texts("method.sha256"), method.sha256), *called]
