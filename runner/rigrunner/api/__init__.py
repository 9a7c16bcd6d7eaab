"""The public, stable contracts between Rigrunner and its plugins.

A plugin or a report imports names from here, `from rigrunner.api import Settings, hookimpl`, and
computes with `rigrunner.signal`. The module of a name is loaded on first use: declarations of
plugins (records, settings, errors, devices) load without numpy. Contracts for few plugins, such as
those of figures, are in the modules of this package.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any

from rigrunner.moved import moved

_NAMES = {
    "hooks": (
        "hookimpl AnalysisRecord CertificateFormatRecord DecisionRuleRecord DeviceRecord "
        "EventSinkRecord FitRecord Imported ImporterExample ImporterRecord KindRecord NoSettings "
        "OutlierRuleRecord ReportFormatRecord StepRecord StudyFormatRecord UnitRecord"
    ),
    "errors": (
        "DataError DeviceError DeviceLostError DeviceNotFoundError DeviceRejectedError "
        "DeviceTimeoutError Location MissingPackageError PluginError RigrunnerError"
    ),
    "settings": (
        "Angle AnyQuantity Duration Force Frequency Length ListOf PlainText PositiveDuration "
        "Ratio Settings SimulableSettings Temperature Torque UnitSymbol WrapperSettings YesNo"
    ),
    "units": "QuantityError find_unit unit",
    "unit_tables": "UnitDefinition",
    "quantity": "Estimate Quantity parse_quantity",
    "member": "Member",
    "devices": (
        "Approaching ChannelInfo Clock Device DeviceContext DriveInfo Identity Pausable "
        "Readable Settable StopToken Streaming"
    ),
    "driver": "Driver",
    "lines": "Answering LineDriver LineSettings",
    "streaming": "StreamingDriver",
    "steps": "Action Doing StepResult Planning StepSettings",
    "importing": "Column Importer NotInFileError",
    "data": "Array Block Mask Measurement Points Recording RunData",
    "instruments": "Instrument",
    "findings": "Findings MeasurementResult Objection ResultDefinition",
    "analysis": (
        "Check Component Curve Fit NeededChannel NeededRun OutlierRule Rejection Requirements "
        "Spreading"
    ),
    "analysis_context": "AnalysisContext",
    "partners": "PartnerRun",
    "uncertainty": "Distribution Effect Input MeasurementModel",
    "verdict": "Limits Verdict Zone",
    "events": "Event EventSink",
    "details": "AnalysisDetails",
    "results": "ReportInput",
    "letterhead": "CertificateInput",
    "studies": "StudyInput",
}
"""Names by module; `__init__.pyi` lists them for type checkers."""
_MODULE_OF = {name: module for module, names in _NAMES.items() for name in names.split()}

__all__: list[str] = sorted(_MODULE_OF)  # noqa: PLE0605  (type checkers read the list in the stub)


def __getattr__(name: str) -> Any:
    """Load the module of a name; raise AttributeError for any other name."""
    if name not in _MODULE_OF:
        return moved(__name__, name)
    value = getattr(import_module(f"{__name__}.{_MODULE_OF[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """Return the public names."""
    return [*__all__, *(name for name in globals() if name.startswith("__"))]
