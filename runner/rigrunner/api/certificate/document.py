"""The whole certificate, and the JSON that it is written as."""

from __future__ import annotations

import json
from typing import Literal

from pydantic import ValidationError

from rigrunner.api.certificate.conformity import Conformity
from rigrunner.api.certificate.evidence import Amendment, Appearance, Evidence, FurtherCopy
from rigrunner.api.certificate.measured import MeasuredLimits
from rigrunner.api.certificate.method import (
    Condition,
    InstrumentEntry,
    Method,
    Performance,
    Traceability,
    ValidityCondition,
)
from rigrunner.api.certificate.part import Part, Text
from rigrunner.api.certificate.parties import Authorisation, Customer, Item, Laboratory
from rigrunner.api.certificate.remarks import Deviation, ExternalResult, Opinion, Restriction
from rigrunner.api.certificate.results import (
    MeasurementModel,
    NamedResult,
    RejectedCycle,
    Results,
)
from rigrunner.api.errors import DataError, first_problem
from rigrunner.api.partner_keys import KEYS, ONLY_AFTER

_IN_SCRIPT = str.maketrans({"<": "\\u003c", ">": "\\u003e", "&": "\\u0026"})
"""JSON escapes with which a text can be inside an HTML element unchanged."""


class Certificate(Part):
    """A test certificate."""

    rigrunner: Literal["certificate/1"] = "certificate/1"
    number: Text
    """Unique in the laboratory; on every page."""
    issued_utc: Text
    restrictions: tuple[Restriction, ...] = ()
    """With any of them the document is marked 'not for certification' on every page."""
    amends: Amendment | None = None
    further_copy: FurtherCopy | None = None
    """For a further specimen on the same run."""
    laboratory: Laboratory
    customer: Customer
    item: Item
    method: Method
    performance: Performance
    conditions: tuple[Condition, ...]
    conditions_stated: str = ""
    """A statement by a person on the conditions."""
    results: Results | None
    """None without an analysis: then the measured values were tested."""
    named: tuple[NamedResult, ...] = ()
    """Named results of analyses."""
    models: tuple[MeasurementModel, ...] = ()
    """The equations and budgets of named results; older documents have none."""
    validity: tuple[ValidityCondition, ...] = ()
    """The conditions on which the results hold; documents of 0.1.0 have none."""
    traceability: Traceability | None = None
    """None in documents of 0.1.0."""
    conformity: Conformity | None
    """The decision on the results; None if the procedure has no limits for them."""
    measured: MeasuredLimits | None = None
    """The measured values with limits; None if there are none."""
    opinions: tuple[Opinion, ...] = ()
    external: tuple[ExternalResult, ...] = ()
    deviations: tuple[Deviation, ...]
    rejected: tuple[RejectedCycle, ...]
    instruments: tuple[InstrumentEntry, ...]
    statements: tuple[Text, ...] = ()
    """Further statements of the laboratory on each certificate."""
    authorisation: Authorisation
    evidence: Evidence
    appearance: Appearance
    seal: str | None = None
    """Of a file: SHA-256 of its bytes before this member, and digests of its blocks."""

    @property
    def verdict(self) -> str:
        """The verdict on the item: of its measured values and its results; '' for none."""
        measured = "" if self.measured is None else self.measured.verdict
        # The worse of the two; measured values only pass or fail.
        if measured == "fail" or self.conformity is None:
            return measured
        return self.conformity.verdict


def certificate_json(certificate: Certificate) -> str:
    """Return the certificate as JSON: the same content gives the same bytes (UTF-8).

    `<`, `>` and `&` are escaped, so that the same text is in the file and inside a page. A
    member that older certificates do not have is left out if it is empty.
    """
    exclude = {"seal"} | {
        name for name in ("measured", "named", "models") if not getattr(certificate, name)
    }
    content = certificate.model_dump(mode="json", exclude=exclude)
    if certificate.conformity is not None and not certificate.conformity.rule_words_in:
        del content["conformity"]["rule_words_in"]
    after = KEYS[ONLY_AFTER]
    if content["evidence"][after] is None:
        del content["evidence"][after]
    if not certificate.evidence.partner_runs:
        del content["evidence"]["partner_runs"]
    text = json.dumps(content, ensure_ascii=False, indent=1, allow_nan=False)
    return text.translate(_IN_SCRIPT) + "\n"


def parse_certificate(text: str | bytes, name: str) -> Certificate:
    """Return the certificate in a JSON text; `name` stands for the file in messages.

    Raises DataError that names the first field that is wrong.
    """
    try:
        certificate = Certificate.model_validate_json(text)
        json.loads(text, object_pairs_hook=_once)
    except _TwiceError as error:  # of two members of one name some programs read the first
        raise DataError(f"{name} is not a certificate: '{error}' is given twice") from error
    except ValidationError as error:
        count = error.error_count()
        more = f" (and {count - 1} more)" if count > 1 else ""
        raise DataError(
            f"{name} is not a certificate: {first_problem(error)}{more}",
            hint="expected the JSON file that 'rigrunner certify' wrote",
        ) from error
    return certificate


class _TwiceError(Exception):
    """Two members of an object have one name."""


def _once(members: list[tuple[str, object]]) -> None:
    names = [name for name, _ in members]
    if len(set(names)) < len(names):
        raise _TwiceError(next(name for name in names if names.count(name) > 1)[:60])
