"""The content of a test certificate (ISO/IEC 17025:2017, 7.8): one model for JSON, HTML and PDF.

Each printed number is here twice: as a float, and as the printed text with its decimals, so that a
reader can recompute the one and compare it with the other. It has codes and facts; the texts in a
natural language are part of the formats.
"""

from rigrunner.api.certificate.conformity import (
    Conformity,
    DecisionRecord,
    LimitStatement,
)
from rigrunner.api.certificate.details import CertifiedDetails
from rigrunner.api.certificate.document import (
    Certificate,
    certificate_json,
    parse_certificate,
)
from rigrunner.api.certificate.evidence import (
    Amendment,
    Appearance,
    Change,
    Evidence,
    FurtherCopy,
    RunEvidence,
)
from rigrunner.api.certificate.measured import MeasuredLimits, MeasuredValue
from rigrunner.api.certificate.method import (
    Approval,
    Condition,
    InstrumentEntry,
    Method,
    Performance,
    Traceability,
    ValidityCondition,
)
from rigrunner.api.certificate.part import (
    Part,
    Sha256,
    Text,
)
from rigrunner.api.certificate.parties import (
    Authorisation,
    Customer,
    Item,
    Laboratory,
)
from rigrunner.api.certificate.remarks import (
    Deviation,
    DeviationKind,
    ExternalResult,
    Opinion,
    Restriction,
)
from rigrunner.api.certificate.results import (
    BudgetLine,
    CoordinatePart,
    Equation,
    MeasurementModel,
    NamedResult,
    PointResult,
    RejectedCycle,
    Results,
    StatedResult,
)

__all__ = [
    "Amendment",
    "Appearance",
    "Approval",
    "Authorisation",
    "BudgetLine",
    "Certificate",
    "CertifiedDetails",
    "Change",
    "Condition",
    "Conformity",
    "CoordinatePart",
    "Customer",
    "DecisionRecord",
    "Deviation",
    "DeviationKind",
    "Equation",
    "Evidence",
    "ExternalResult",
    "FurtherCopy",
    "InstrumentEntry",
    "Item",
    "Laboratory",
    "LimitStatement",
    "MeasuredLimits",
    "MeasuredValue",
    "MeasurementModel",
    "Method",
    "NamedResult",
    "Opinion",
    "Part",
    "Performance",
    "PointResult",
    "RejectedCycle",
    "Restriction",
    "Results",
    "RunEvidence",
    "Sha256",
    "StatedResult",
    "Text",
    "Traceability",
    "ValidityCondition",
    "certificate_json",
    "parse_certificate",
]
