"""The records that plugins declare; each hook is a plural noun and returns a list of records.

The `factory` of a record is called with the validated settings. An `Imported` one is loaded then:
plugins are listed, and procedures checked, without loading numpy.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pluggy

from rigrunner.api.analysis.requirements import Requirements
from rigrunner.api.errors import PluginError
from rigrunner.api.settings import Settings
from rigrunner.api.steps import StepSettings
from rigrunner.moved import moved

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

    from rigrunner.api.analysis import Fit, OutlierRule
    from rigrunner.api.devices import Device, DeviceContext
    from rigrunner.api.events import EventSink
    from rigrunner.api.findings import (
        Analysis,
        AnalysisOfResults,
        LiveAnalysis,
        Objection,
        ResultDefinition,
    )
    from rigrunner.api.importing import Importer
    from rigrunner.api.letterhead import CertificateInput
    from rigrunner.api.planned import ExpectedReading, PlanProblem
    from rigrunner.api.results import ReportInput
    from rigrunner.api.studies import StudyInput
    from rigrunner.api.unit_tables import Unit, UnitDefinition
    from rigrunner.api.verdict import DecisionRule

API_VERSION = 1
"""The present plugin API; a plugin module made for it has `api_version = 1`."""
OLDEST_API_VERSION = 1
"""The oldest plugin API that is still supported."""
PROJECT = "rigrunner"
hookspec = pluggy.HookspecMarker(PROJECT)
hookimpl = pluggy.HookimplMarker(PROJECT)


class NoSettings(Settings):
    """The settings of a plugin that has none."""


def needs_nothing(settings: Any) -> Requirements:  # noqa: ARG001  (of any settings)
    """Return no requirements."""
    return Requirements()


@dataclass(frozen=True)
class Imported:
    """A function or class of a record that is imported when it is called."""

    place: str
    """Its path, 'package.module:name'."""
    called: bool = True
    """False for a factory that gives it as it is, such as a function that has no settings."""

    def __call__(self, *args: Any, **kwargs: Any) -> Any:
        """Import it, and call it if so declared; raise PluginError if the path leads to nothing."""
        module, _, name = self.place.partition(":")
        try:
            target = getattr(import_module(module), name)
        except (ImportError, AttributeError, ValueError) as error:
            reason = f"{type(error).__name__}: {error}"
            raise PluginError(
                f"'{self.place}' cannot be loaded: {reason}",
                hint="a record names a function or class as 'package.module:name'",
            ) from error
        return target(*args, **kwargs) if self.called else target


@dataclass(frozen=True, kw_only=True)
class PluginRecord:
    """What every plugin declares: its name in YAML, its settings and one line of help."""

    name: str
    """In YAML: small letters, digits and '_'."""
    help: str
    """One line for lists; at most 100 characters."""
    settings: type[Settings] | str = NoSettings
    """The model of its settings; the docstring under a field explains the field to users.

    Or its path, 'package.module:Name', which is imported when first needed.
    """
    trial: Mapping[str, Any] = field(default_factory=dict)
    """Settings for a trial, of a device without an instrument."""
    rig: type[Settings] | str | None = None
    """The model of the keys that it reads under `rig` of a station, or its path, as for `settings`.

    A key that no plugin declares is refused. A key without a default is required where the plugin
    is used.
    """
    revision: int = 1
    """Revision of a method or a page layout; increased by each change of its numbers or pages.

    Runs and documents record it. `verify` recomputes with the recorded revision, and reports if
    another one is installed. A correction of a mistake is a new revision too.
    """

    @property
    def settings_model(self) -> type[Settings]:
        """The model of the settings; raises PluginError if the path leads to none."""
        return _model_at(self.settings) if isinstance(self.settings, str) else self.settings

    @property
    def rig_model(self) -> type[Settings] | None:
        """The model of the keys of the rig; raises PluginError if the path leads to none."""
        return _model_at(self.rig) if isinstance(self.rig, str) else self.rig


@dataclass(frozen=True, kw_only=True)
class DeviceRecord(PluginRecord):
    """A device: `factory(settings, context)` does no I/O."""

    factory: Callable[[Any, DeviceContext], Device]
    """Makes the device from its settings and a DeviceContext."""
    simulated: bool = False
    """True if there is never an instrument; for SimulableSettings the settings decide."""
    wired: bool = False
    """True if every exchange with the instrument goes through `context.wire`."""
    reopenable: bool = True
    """True if another process can open the device after the first one died; the guardian does so.
    """
    stop_latency_s: float = 1.0
    """Longest time for which a stream continues after a stop request."""
    absent: Mapping[str, Any] = field(default_factory=dict)
    """Settings, merged into others, for which no instrument answers."""


@dataclass(frozen=True, kw_only=True)
class OutlierExample:
    """Values for which a source states which of them a rule rejects."""

    source: str
    values: tuple[float, ...]
    rejected: tuple[int, ...]
    """Indices, counted from 0."""
    settings: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class OutlierRuleRecord(PluginRecord):
    """A rule for gross errors: `factory(settings)`."""

    factory: Callable[[Any], OutlierRule]
    """Makes the rule from the settings."""
    rejects: bool = True
    """False for a rule that keeps every value."""
    requires: Callable[[Any], Requirements] = needs_nothing
    """Returns, from the settings, what the rule requires of a run."""
    leaves_at_least: int = 2
    """The number of values that it keeps of any larger sample."""
    examples: tuple[OutlierExample, ...] = ()
    """Examples for the conformance kit, in addition to the checks of every rule."""


@dataclass(frozen=True, kw_only=True)
class FitExample:
    """Points for which a source states the result of a fit."""

    source: str
    x: tuple[float, ...]
    y: tuple[float, ...]
    coefficients: tuple[float, ...]
    u: tuple[float, ...] = ()
    """Standard uncertainties of y, if the source states them."""
    settings: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class FitRecord(PluginRecord):
    """A fit of y over x: `factory(settings)`."""

    factory: Callable[[Any], Fit]
    """Makes the fit from the settings."""
    requires: Callable[[Any], Requirements] = needs_nothing
    """Returns, from the settings, what the fit requires of a run."""
    examples: tuple[FitExample, ...] = ()
    """Examples for the conformance kit, in addition to the checks of every fit."""


@dataclass(frozen=True, kw_only=True)
class DecisionRuleRecord(PluginRecord):
    """A decision rule, which turns a result and its limits into a verdict: `factory(settings)`."""

    factory: Callable[[Any], DecisionRule]
    """Makes the rule from the settings."""
    passes_outside: bool = False
    """Whether a value outside its limits can pass: a guard band outwards (JCGM 106, 8.3.3)."""


def nothing(*_: Any) -> tuple[Any, ...]:
    """Return an empty sequence for any settings."""
    return ()


@dataclass(frozen=True, kw_only=True)
class AnalysisRecord(PluginRecord):
    """An analysis of any quantity: `factory(settings)`.

    Its settings alone state its results and requirements, so limits and channels are checked before
    anything moves.
    """

    factory: Callable[..., Analysis | AnalysisOfResults]
    """Makes the analysis from the settings and the fits that they name (see `FitChoice`). An
    analysis that requires results is called with these too."""
    in_context: bool = False
    """Whether `factory`, `yields`, `requires`, `live` and the functions of a planned run get an
    AnalysisContext as their last argument: it has the other plugins, and what the procedure
    measures."""
    yields: Callable[..., tuple[ResultDefinition, ...]]
    """Returns, from the settings, the results that the analysis makes."""
    requires: Callable[..., Requirements] = needs_nothing
    """Returns, from the settings, what the analysis requires of a run, above all channels."""
    objections: Callable[[Any, Mapping[str, str]], Iterable[Objection]] = nothing
    """Returns, from the settings and the units of the requirements by name, settings that do not
    fit. Channels have SI units; results have their own. The parameters of a fit that a field names
    are there too, as 'fit.c0', if the fit declares them."""
    partner_problems: Callable[..., Iterable[str]] = nothing
    """Returns, from the settings, a planned run and a run that could be its partner, why that run
    cannot be used, beyond what `requires` asks of it."""
    plan_problems: Callable[..., Iterable[PlanProblem]] = nothing
    """Returns, from the settings and a PlannedRun, why the analysis cannot use what the run will
    measure, beyond what `requires` asks of it."""
    entering: Callable[..., Iterable[str]] | None = None
    """Returns, from the settings and a PlannedRun, the channels whose values enter the results and
    that must be calibrated; None: those that `requires` names."""
    expects: Callable[..., Iterable[ExpectedReading]] = nothing
    """Returns, from the settings and a PlannedRun, what channels will probably show: the plan and
    the check of calibrated ranges use it."""
    live: Callable[..., LiveAnalysis] | None = None
    """Makes, from the settings, the live view of a measurement; None for no live view."""
    measurand: str = ""
    """The dimension of its result, such as 'voltage', if that is the `measurand` of the procedure,
    which gives it symbol, name and unit. A procedure has one such analysis at most. '' for an
    analysis whose settings name its results."""
    limit_measurand: type[Settings] | str | None = None
    """The model of the key `measurand` of limits of its results, or its path, as for `settings`; it
    has what a LimitedMeasurand has. None: its results need no such key."""
    changed: Callable[[Any, Any], Settings] | None = None
    """Returns the settings by which a stored run is analysed in another way, from its own and from
    others of which only the fields that were set count. Raises DataError 'KEY: why' where they
    contradict each other. None: the settings are replaced as a whole."""
    trial_units: Mapping[str, str] = field(default_factory=dict)
    """The SI unit of each channel in `trial`, for which the conformance kit makes up values."""
    trial_run: str = ""
    """Path, 'package.module:function', of a function that returns a RunData for a number 0, 1, ...,
    such as from a simulated rig; for an analysis that finds nothing in made-up values."""

    @property
    def limit_measurand_model(self) -> type[Settings] | None:
        """The model of the key `measurand`; raises PluginError if the path leads to none."""
        model = self.limit_measurand
        return _model_at(model) if isinstance(model, str) else model


@dataclass(frozen=True, kw_only=True)
class ReportFormatRecord(PluginRecord):
    """A report: `factory(settings)` returns a function from ReportInput to the bytes of a file."""

    suffix: str
    """Suffix of the file, with the dot."""
    factory: Callable[[Any], Callable[[ReportInput], bytes]]
    """Makes the writer from the settings."""


@dataclass(frozen=True, kw_only=True)
class CertificateFormatRecord(PluginRecord):
    """A printed form of certificates: `factory(settings)` returns a function to bytes.

    The factory raises MissingPackageError if a package that it needs is not installed. The function
    raises InvalidFileError if texts or templates of the letterhead are wrong.
    """

    suffix: str
    """Suffix of the file, with the dot."""
    factory: Callable[[Any], Callable[[CertificateInput], bytes]]
    """Makes the writer from the settings."""


@dataclass(frozen=True, kw_only=True)
class StudyFormatRecord(PluginRecord):
    """A report on many runs: `factory(settings)` returns a function to the bytes of a file."""

    suffix: str
    """Suffix of the file, with the dot."""
    factory: Callable[[Any], Callable[[StudyInput], bytes]]
    """Makes the writer from the settings."""


@dataclass(frozen=True, kw_only=True)
class ImporterExample:
    """A small file with known content."""

    source: str
    """The origin of the file."""
    content: bytes
    """The whole file."""
    columns: Mapping[str, int | str]
    """The column of the file for each name, as in a mapping."""
    values: Mapping[str, tuple[float, ...]]
    """The values of these columns, by the same names."""
    suffix: str = ""
    """Suffix of the file name."""
    group: str = ""
    """The part of the file with these columns."""


@dataclass(frozen=True, kw_only=True)
class ImporterRecord(PluginRecord):
    """A reader of files of other programs: `factory(settings)`.

    The factory raises MissingPackageError if a package that it needs is not installed.
    """

    factory: Callable[[Any], Importer]
    """Makes the reader from the settings."""
    examples: tuple[ImporterExample, ...] = ()
    """Examples for the conformance kit, in addition to the checks of every importer."""


@dataclass(frozen=True, kw_only=True)
class EventSinkRecord(PluginRecord):
    """A guarded listener to the events of a run: `factory(settings)`.

    A station names it under `listeners`. It runs in its own thread; one that raises, or cannot keep
    up with the run, is dropped with an alarm.
    """

    factory: Callable[[Any], EventSink]
    """Makes the listener from the settings."""


@dataclass(frozen=True, kw_only=True)
class StepRecord(PluginRecord):
    """A kind of step, by its name in procedures; its settings are StepSettings.

    `help` describes it in one line, and the docstrings of the model describe its keys. The schema
    for editors and the reference of the language are generated from them.
    """

    factory: Callable[[Any, Any], None]
    """Plans the step: `factory(settings, planning)` passes each action to `planning`, a Planning.
    """
    example: str = ""
    """An example in one line."""

    @property
    def steps_model(self) -> type[StepSettings]:
        """The model of the settings; raises PluginError if it is not a model of a step."""
        model = self.settings_model
        if not issubclass(model, StepSettings):
            raise PluginError(f"the settings of the step '{self.name}' are not StepSettings")
        return model


@dataclass(frozen=True, kw_only=True)
class UnitRecord(PluginRecord):
    """A unit of measurement, accepted by its symbol wherever a quantity is written."""

    definition: UnitDefinition
    """The symbol, the kind of quantity with its dimension, and the size of the unit."""

    def factory(self, settings: Any) -> Unit:  # noqa: ARG002  (there are none)
        """Return the unit."""
        return self.definition.unit


@dataclass(frozen=True, kw_only=True)
class LabRecord(PluginRecord):
    """A lab folder made by `rigrunner init`.

    Letterhead, reports and schemas are the same in every lab folder; the record adds the other
    files.
    """

    files: str
    """Path of the files, 'package:folder': station.yaml, README.md, plugins, procedures."""
    procedures: tuple[str, ...] = ()
    """Shipped procedures to copy, in the order in which to run them."""

    def factory(self, settings: Any) -> Path:  # noqa: ARG002  (there are none)
        """Return the folder with the files."""
        return _folder_at(self.files)


@dataclass(frozen=True, kw_only=True)
class KindRecord(PluginRecord):
    """A kind of plugin; plugins of it are returned by a function with the name `hook`.

    `name` and `help` describe the kind. The package that provides it uses its plugins, and states
    what they must comply with.
    """

    hook: str
    """Name of the hook function: 'rigrunner_' and a plural noun."""
    record: type[PluginRecord]
    """Type of the records in the list that the hook returns."""
    takes: tuple[str, ...] = ()
    """Names of the arguments of what the factory of a record makes, if that is a function."""
    conformance: str = ""
    """Path, 'package.module', of `CHECKS`, the checks of the conformance kit for such plugins, and
    `SUBJECT`, the class of `rigrunner_testing` that is passed to them."""
    template: str = ""
    """Path, 'package:folder', of the templates of `rigrunner new`: `KIND.py.jinja` and
    `test_KIND.py.jinja`."""

    def factory(self, settings: Any) -> type[PluginRecord]:  # noqa: ARG002  (there are none)
        """Return the type of its records."""
        return self.record

    @property
    def templates(self) -> Path:
        """The folder of the templates."""
        return _folder_at(self.template)


class HookSpecs:
    """The hooks; each returns any number of records."""

    @hookspec
    def rigrunner_steps(self) -> Iterable[StepRecord]:
        """Return the kinds of steps that this plugin provides."""
        raise NotImplementedError

    @hookspec
    def rigrunner_devices(self) -> Iterable[DeviceRecord]:
        """Return the devices that this plugin provides."""
        raise NotImplementedError

    @hookspec
    def rigrunner_outlier_rules(self) -> Iterable[OutlierRuleRecord]:
        """Return the rules for gross errors that this plugin provides."""
        raise NotImplementedError

    @hookspec
    def rigrunner_fits(self) -> Iterable[FitRecord]:
        """Return the fits that this plugin provides."""
        raise NotImplementedError

    @hookspec
    def rigrunner_decision_rules(self) -> Iterable[DecisionRuleRecord]:
        """Return the decision rules that this plugin provides."""
        raise NotImplementedError

    @hookspec
    def rigrunner_analyses(self) -> Iterable[AnalysisRecord]:
        """Return the analyses of any quantity that this plugin provides."""
        raise NotImplementedError

    @hookspec
    def rigrunner_report_formats(self) -> Iterable[ReportFormatRecord]:
        """Return the report formats that this plugin provides."""
        raise NotImplementedError

    @hookspec
    def rigrunner_certificate_formats(self) -> Iterable[CertificateFormatRecord]:
        """Return the printed forms of certificates that this plugin provides."""
        raise NotImplementedError

    @hookspec
    def rigrunner_study_formats(self) -> Iterable[StudyFormatRecord]:
        """Return the formats of reports on many runs that this plugin provides."""
        raise NotImplementedError

    @hookspec
    def rigrunner_importers(self) -> Iterable[ImporterRecord]:
        """Return the readers of other programs' files that this plugin provides."""
        raise NotImplementedError

    @hookspec
    def rigrunner_event_sinks(self) -> Iterable[EventSinkRecord]:
        """Return the listeners to events that this plugin provides."""
        raise NotImplementedError

    @hookspec
    def rigrunner_labs(self) -> Iterable[LabRecord]:
        """Return the lab folders to begin with that this plugin provides."""
        raise NotImplementedError

    @hookspec
    def rigrunner_kinds(self) -> Iterable[KindRecord]:
        """Return the kinds of plugins that this plugin provides."""
        raise NotImplementedError

    @hookspec
    def rigrunner_units(self) -> Iterable[UnitRecord]:
        """Return the units of measurement that this plugin provides."""
        raise NotImplementedError


def _folder_at(place: str) -> Path:
    package, _, folder = place.partition(":")
    return Path(str(import_module(package).__file__)).parent / folder


def __getattr__(name: str) -> Any:
    return moved(__name__, name)


def _model_at(place: str) -> type[Settings]:
    module, _, name = place.partition(":")
    try:
        model = getattr(import_module(module), name)
    except (Exception, SystemExit) as error:  # a module of a plugin may do anything
        reason = f"{type(error).__name__}: {error}"
        raise PluginError(f"the settings '{place}' cannot be loaded: {reason}") from error
    if not (isinstance(model, type) and issubclass(model, Settings)):
        raise PluginError(f"'{place}' is not a model of settings")
    return model
