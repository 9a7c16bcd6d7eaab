"""Show a result document as some lines and a table, for a terminal of 80 columns."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING, Any

from rigrunner.api.events import Outcome
from rigrunner.api.summaries import GROUP, SummaryParts, pairs, table
from rigrunner.api.units import with_symbol
from rigrunner.api.verdict import probability_text, risk_text
from rigrunner.cli.output import message
from rigrunner.cli.package_commands import entries
from rigrunner.run.set_points import other_results, unread
from rigrunner.signal.rounding import estimate_text

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

    Document = Mapping[str, Any]

MOST_SHOWN = 20
"""The number of values out of limits that are listed; 'show' has the whole tables."""


def summary(document: Document) -> str:
    """Return the verdict, the results, the failed checks, and what other packages add."""
    packages = tuple(package_summaries())
    facts = (fact for package in packages for fact in package.facts(document))
    parts = [
        pairs([*facts, *_verdict(document)]),
        *(block for package in packages for block in package.blocks(document)),
        _results(document),
        _failed_checks(document, (check for each in packages for check in each.checks(document))),
        *(f"not shown: {key}, as no installed package reads it" for key in unread(document)),
    ]
    return "\n\n".join(part for part in parts if part)


def package_summaries() -> Iterator[SummaryParts]:
    """Yield the additions of each installed package; one that cannot be imported is reported."""
    for name, entry in sorted(entries(GROUP).items()):
        try:
            yield entry.load()
        except Exception as error:  # noqa: BLE001  (third-party code may raise anything)
            message(f"the summary of '{name}' cannot be loaded: {error}")


def identity(document: Document) -> str:
    """Return the procedure and the run of the result."""
    run = document["run"]
    title, name, revision = (run["procedure"][key] for key in ("title", "id", "revision"))
    state, approval = "draft: not for certification", run.get("approval", {})
    if approval.get("state") == "approved":
        state = f"approved by {approval['by']} on {approval['utc'][:10]}"
    return pairs(
        [
            ("procedure", f"{title} ({name}, revision {revision})"),
            ("state", state),
            ("run", run["id"]),
            *([("imported", f"recorded by {by}")] if (by := recorded_by(run)) else []),
        ]
    )


def recorded_by(run: Document) -> str:
    """Return the program that made the recordings of an imported run; '' for any other."""
    return str((run.get("imported") or {}).get("program", ""))


def _verdict(document: Document) -> Iterator[tuple[str, str]]:
    decision = document["decision"]
    if document.get("limits"):
        yield from _limits(document)
        if decision:
            yield "of the result", f"{decision['verdict']}: {decision['reason']}"
            yield from _details(decision)
    elif decision:
        yield from _decision(decision, document["run"].get("outcome", Outcome.COMPLETED))


def _limits(document: Document) -> Iterator[tuple[str, str]]:
    """Report the verdict on a run with limits of measured values, and values out of limits."""
    limits, verdict = document["limits"], document["verdict"]
    if verdict is None:
        yield "verdict", f"none: the run ended as '{document['run']['outcome']}'"
    else:
        yield "verdict", f"{verdict['verdict'].upper()}: {verdict['reason']}"
    missed = [value for value in limits["values"] if value["verdict"] == "fail"]
    for value in missed[:MOST_SHOWN]:
        yield f"{value['table']} {value['row']}", value["text"]
    if limits["missed"] > MOST_SHOWN:
        yield "and more", f"{limits['missed'] - MOST_SHOWN} values out of limits"


def _decision(decision: Document, outcome: str) -> Iterator[tuple[str, str]]:
    """Report verdict, reason, probability and risk. `.get` is for keys that older files lack."""
    verdict = f"{decision['verdict'].upper()}: {decision['reason']}"
    if outcome == Outcome.COMPLETED:
        yield "verdict", verdict
    else:
        yield (
            "verdict",
            f"none: the run was not completed ({outcome}), and neither passes nor fails",
        )
        yield "by the rule", f"what was recorded would be {verdict}"
    yield from _details(decision)


def _details(decision: Document) -> Iterator[tuple[str, str]]:
    """Report the risk of a decision, and its limits."""
    if decision.get("marginal"):
        yield "marginal", "a difference within the marginal band would change the verdict"
    probability = decision.get("probability_of_conformity")
    if probability is not None:
        yield "conformity", f"{probability_text(probability)} probable; {stated_risk(decision)}"
    if decision["verdict_uncompensated"]:
        yield "uncompensated", decision["verdict_uncompensated"]
    parts = decision.get("parts", ())
    if len(parts) > 1:
        tally = Counter(part["verdict"] for part in parts)
        counts = ", ".join(f"{count} {verdict}" for verdict, count in tally.items())
        yield "limits", f"{len(parts)}: {counts}"
        mixed = len({part.get("named") for part in parts}) > 1
        for part in parts:
            # the result of the headline by its name, if others have limits too
            is_named = mixed and part.get("measurand")
            label = f"{part['named']}, {part['of']}" if is_named else str(part["of"])
            value = with_symbol(estimate_text(part["result"]), part["upper_limit"]["unit"])
            yield label, f"{part['verdict']}: {value} against {part['limit']}"


def stated_risk(decision: Document) -> str:
    """Return the risk that the rule implies, as text."""
    risk = (decision.get("stated_risk") or {}).get("false_accept")
    if risk is None:
        return "no value could pass"
    return f"at most {risk_text(risk)} risk in a pass of this rule"


def _results(document: Document) -> str:
    """Return the named results of analyses: a table of each, by its coordinates."""
    results = [*other_results(document), *document.get("missing", ())]
    tables = []
    for name in dict.fromkeys(result["name"] for result in results):
        same = [result for result in results if result["name"] == name]
        first = same[0]
        symbol = f", {first['symbol']}" if first["symbol"] else ""
        unit = first["unit"] if "why" in first else first["estimate"]["unit"]
        caption = f"{first['text'] or name}{symbol}, in {unit}, with U (95 %)"
        header = [*first["coordinates"], name, "readings"]
        rows, reasons = [], []
        for result in same:
            place = {key: coordinate_text(value) for key, value in result["coordinates"].items()}
            cells = ["no value", ""]
            if "why" in result:
                point = ", ".join(f"{key} = {text}" for key, text in place.items())
                reasons.append(f"no value{f' at {point}' if point else ''}: {result['why']}")
            else:
                estimate = result["estimate"]
                value = f"{estimate['value']:.6g}, U unknown"
                if estimate["expanded_uncertainty_95"] is not None:
                    value = estimate_text(estimate)
                cells = [value, str(result["readings"])]
            rows.append([*(place[key] for key in first["coordinates"]), *cells])
        tables.append("\n".join([caption, table(header, rows, "r" * len(header)), *reasons]))
    return "\n\n".join(tables)


def coordinate_text(value: str | Mapping[str, Any]) -> str:
    """Return a coordinate of a result document: '2 A', 'final'."""
    if isinstance(value, str):
        return value
    return with_symbol(f"{value['value']:.6g}", value["unit"])


def _failed_checks(document: Document, method_checks: Iterable[Document]) -> str:
    checks = [
        check
        for check in (*document["checks"], *method_checks)
        if not check["ok"] or check.get("consequence")
    ]
    lines = []
    for check in sorted(checks, key=lambda check: bool(check["ok"])):
        kind = "note" if check["ok"] else "check"
        words = (f"{kind}: {check['name']}: {check['text']}", check.get("effect"), check["advice"])
        lines.append("; ".join(part for part in words if part))
    return "\n".join(lines)
