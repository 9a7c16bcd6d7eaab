"""Amendments: a document that replaces another with the same measurements.

ISO/IEC 17025:2017, 7.8.8: a further document with its own number, which names the original; every
change of information is identified, with the reason.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.certificate import Amendment, Appearance, Certificate, Change
from rigrunner.api.errors import UsageError

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rigrunner.api.certificate import Conformity
    from rigrunner.api.letterhead import Letterhead
    from rigrunner.certificate.content import Issue
    from rigrunner.certificate.withdrawal import UnreadableWithdrawal, Withdrawal

PLACES = {
    "customer": ("customer", "name"),
    "customer_contact": ("customer", "contact"),
    "customer_reference": ("customer", "reference"),
    "item": ("item", "description"),
    "item_id": ("item", "identification"),
    "item_condition": ("item", "condition"),
    "received": ("item", "received"),
    "sampling": ("item", "sampling"),
    "operator": ("performance", "operator"),
}
"""The place of each field of an order in a certificate."""


def amended(
    original: Certificate,
    values: Mapping[str, str],
    letterhead: Letterhead,
    issue: Issue,
    conformity: Conformity | None,
) -> Certificate:
    """Return the amended document; `issue.amends` names the original, the changes are added.

    `conformity` is the statement of a later decision. Raises UsageError for an unchanged or invalid
    value.
    """
    assert issue.amends is not None  # noqa: S101  (the caller amends)
    changes = list(issue.amends.changes)
    for name, value in values.items():
        part, field = PLACES[name]
        old = getattr(getattr(original, part), field)
        if value == old:
            option = f"--{name.replace('_', '-')}"
            raise UsageError(f"{option} is '{old}' in {original.number} already")
        changes.append(Change(field=f"{part}.{field}", before=old, after=value))
    if conformity is not None:
        if conformity == original.conformity:
            raise UsageError(f"{original.number} already states the decision in force")
        was, now = _decision(original.conformity), _decision(conformity)
        changes += [
            Change(field=f"conformity.{name}", before=was[name], after=value)
            for name, value in now.items()
            if was[name] != value
        ]
    parts = {
        part: getattr(original, part).model_copy(
            update={
                field: values[name]
                for name, (section, field) in PLACES.items()
                if section == part and name in values
            }
        )
        for part in {part for part, _ in PLACES.values()}
    }
    return original.model_copy(
        update={
            **parts,
            "conformity": conformity or original.conformity,
            "number": issue.number,
            "issued_utc": issue.issued_utc,
            "amends": issue.amends.model_copy(update={"changes": tuple(changes)}),
            "laboratory": letterhead.laboratory,
            "statements": letterhead.statements,
            "authorisation": issue.authorisation,
            "evidence": original.evidence.model_copy(update={"issued_with": dict(issue.software)}),
            "appearance": Appearance(
                language=letterhead.language,
                files=dict(letterhead.files),
                layouts=dict(issue.layouts),
            ),
        }
    )


def amendment_of(
    original: Certificate,
    sha256: str,
    reason: str,
    by: str,
    withdrawal: Withdrawal | UnreadableWithdrawal | None = None,
) -> Amendment:
    """Return the amendment statement; its only change is the withdrawal of the original."""
    ended = withdrawal and Change(field="withdrawal", before=str(withdrawal), after="")
    return Amendment(
        number=original.number,
        issued_utc=original.issued_utc,
        sha256=sha256,
        reason=reason,
        by=by,
        changes=(ended,) if ended else (),
    )


def _decision(conformity: Conformity | None) -> dict[str, str]:
    first = None if conformity is None else conformity.statements[0]
    return {
        "verdict": "" if conformity is None else conformity.verdict,
        "rule": "" if conformity is None else conformity.rule,
        "limit": "" if first is None else first.limit,
        "source": "" if first is None else first.source,
    }
