"""What a plugin declares: hooks are plural nouns that return typed records.

A record's `factory` is called with the validated settings, and imports what it needs then: a plugin
is listed, and a procedure checked, without loading numpy.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pluggy

from rigrunner.api.analysis.requirements import Requirements
from rigrunner.api.errors import PluginError
from rigrunner.api.moved import moved
from rigrunner.api.settings import Settings
from rigrunner.api.steps import StepSettings

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
    from rigrunner.api.results import ReportInput
    from rigrunner.api.studies import StudyInput
    from rigrunner.api.unit_tables import Unit, UnitDefinition
    from rigrunner.api.verdict import DecisionRule

API_VERSION = 1
"""The plugin API as it is now; a plugin's module says `api_version = 1` if it is made for it."""
OLDEST_API_VERSION = 1
"""The oldest one for which plugins are still taken."""
PROJECT = "rigrunner"
hookspec = pluggy.HookspecMarker(PROJECT)
hookimpl = pluggy.HookimplMarker(PROJECT)


class NoSettings(Settings):
    """The settings of a plugin that has none."""


def needs_nothing(settings: Any) -> Requirements:  # noqa: ARG001  (of any settings)
    """Return no requirements."""
    return Requirements()


@dataclass(frozen=True, kw_only=True)
class PluginRecord:
    """What every plugin declares: its name in YAML, its settings and one line of help."""

    name: str
    """In YAML: small letters, digits and '_'."""
    help: str
    """One line for lists, of at most 100 characters."""
    settings: type[Settings] | str = NoSettings
    """Its settings; a docstring under a field explains it to users.

    Or where that stands, as 'package.module:Name': imported once it is needed.
    """
    trial: Mapping[str, Any] = field(default_factory=dict)
    """Settings with which it can be tried, a device without an instrument."""
    rig: type[Settings] | str | None = None
    """The keys that it reads under `rig` of a station, or where they stand, as of `settings`.

    A key that no plugin declares is refused; one without a default must be there where the plugin
    is used.
    """
    revision: int = 1
    """Of a method or a page layout: one more with each change that gives another number or page.

    Runs and documents carry it. `verify` computes numbers again by the revision that made them, and
    says so where another one is installed. Also of a change that fixes a mistake.
    """

    @property
    def settings_model(self) -> type[Settings]:
        """The model of the settings; PluginError if there is none where the record says."""
        return _model_at(self.settings) if isinstance(self.settings, str) else self.settings

    @property
    def rig_model(self) -> type[Settings] | None:
        """The model of its keys of the rig; PluginError if there is none where the record says."""
        return _model_at(self.rig) if isinstance(self.rig, str) else self.rig


@dataclass(frozen=True, kw_only=True)
class DeviceRecord(PluginRecord):
    """A device: `factory(settings, context)` does no I/O."""

    factory: Callable[[Any, DeviceContext], Device]
    """Makes the device of its settings and what it is given beside them."""
    simulated: bool = False
    """Whether there is no instrument at all; of SimulableSettings, the settings say so."""
    wired: bool = False
    """Whether every exchange with the instrument goes through `context.wire`."""
    reopenable: bool = True
    """Whether another process can open it once the one that had it is gone: the guardian does."""
    stop_latency_s: float = 1.0
    """How long a stream may go on after the run was asked to stop."""
    absent: Mapping[str, Any] = field(default_factory=dict)
    """Settings, laid over others, with which nobody answers."""


@dataclass(frozen=True, kw_only=True)
class OutlierExample:
    """Values of which it is known, by a source, which ones a rule rejects."""

    source: str
    values: tuple[float, ...]
    rejected: tuple[int, ...]
    """Counted from 0."""
    settings: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class OutlierRuleRecord(PluginRecord):
    """A rule for gross errors: `factory(settings)`."""

    factory: Callable[[Any], OutlierRule]
    """Makes the rule, of the settings."""
    rejects: bool = True
    """False for a rule that keeps every value."""
    requires: Callable[[Any], Requirements] = needs_nothing
    """Gives, of the settings, what the rule needs of a run."""
    leaves_at_least: int = 2
    """How many values it leaves of any sample that has as many."""
    examples: tuple[OutlierExample, ...] = ()
    """What the conformance kit holds it to, beside what is the same for every rule."""


@dataclass(frozen=True, kw_only=True)
class FitExample:
    """Points of which it is known, by a source, what a fit gives."""

    source: str
    x: tuple[float, ...]
    y: tuple[float, ...]
    coefficients: tuple[float, ...]
    u: tuple[float, ...] = ()
    """Their standard uncertainties, where the source has them."""
    settings: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class FitRecord(PluginRecord):
    """A fit of y over x: `factory(settings)`."""

    factory: Callable[[Any], Fit]
    """Makes the fit, of the settings."""
    requires: Callable[[Any], Requirements] = needs_nothing
    """Gives, of the settings, what the fit needs of a run."""
    examples: tuple[FitExample, ...] = ()
    """What the conformance kit holds it to, beside what is the same for every fit."""


@dataclass(frozen=True, kw_only=True)
class DecisionRuleRecord(PluginRecord):
    """A decision rule, by which limits give a verdict: `factory(settings)`."""

    factory: Callable[[Any], DecisionRule]
    """Makes the rule, of the settings."""
    passes_outside: bool = False
    """Whether a value outside its limits can pass: a guard band outwards (JCGM 106, 8.3.3)."""


def nothing(*_: Any) -> tuple[Any, ...]:
    """Return none, of any settings."""
    return ()


@dataclass(frozen=True, kw_only=True)
class AnalysisRecord(PluginRecord):
    """An analysis of any quantity: `factory(settings)`.

    What it gives and needs is known from its settings alone: so limits and channels are checked
    before anything moves.
    """

    factory: Callable[..., Analysis | AnalysisOfResults]
    """Makes the analysis, of the settings, and of each fit that they name: see `FitChoice`. One
    that requires results is called with them too."""
    in_context: bool = False
    """Whether `factory`, `yields`, `requires` and `live` are given an AnalysisContext too, after
    the settings: it has the other plugins, and what the procedure measures."""
    yields: Callable[..., tuple[ResultDefinition, ...]]
    """Gives, of the settings, the results that it makes."""
    requires: Callable[..., Requirements] = needs_nothing
    """Gives, of the settings, what it needs of a run: above all the channels to measure."""
    objections: Callable[[Any, Mapping[str, str]], Iterable[Objection]] = nothing
    """Gives, of the settings and the units of what it needs, by name, what does not fit. That of a
    channel is its SI unit, that of a result the one in which it is stated."""
    live: Callable[..., LiveAnalysis] | None = None
    """Makes, of the settings, what is shown while it is measured; None for nothing."""
    trial_units: Mapping[str, str] = field(default_factory=dict)
    """The SI unit of each channel that `trial` names: the conformance kit makes up values of it."""
    trial_run: str = ""
    """Of an analysis that finds nothing in made-up values: 'package.module:function', which gives
    for a number 0, 1, ... a run to try it on, a RunData, such as one of a simulated rig."""


@dataclass(frozen=True, kw_only=True)
class ReportFormatRecord(PluginRecord):
    """A report: `factory(settings)` gives a function from ReportInput to the file's bytes."""

    suffix: str
    """Of the file, with its dot."""
    factory: Callable[[Any], Callable[[ReportInput], bytes]]
    """Makes the function that writes, of the settings."""


@dataclass(frozen=True, kw_only=True)
class CertificateFormatRecord(PluginRecord):
    """A printed form of certificates: `factory(settings)` gives a function to the file's bytes.

    The factory raises MissingPackageError if it needs a package that is not installed. The function
    raises InvalidFileError where the letterhead's own texts or templates are wrong.
    """

    suffix: str
    """Of the file, with its dot."""
    factory: Callable[[Any], Callable[[CertificateInput], bytes]]
    """Makes the function that writes, of the settings."""


@dataclass(frozen=True, kw_only=True)
class StudyFormatRecord(PluginRecord):
    """A report on many runs: `factory(settings)` gives a function to the file's bytes."""

    suffix: str
    """Of the file, with its dot."""
    factory: Callable[[Any], Callable[[StudyInput], bytes]]
    """Makes the function that writes, of the settings."""


@dataclass(frozen=True, kw_only=True)
class ImporterExample:
    """A small file of which it is known what stands in it."""

    source: str
    """Where it is from."""
    content: bytes
    """The whole file."""
    columns: Mapping[str, int | str]
    """Which column of the file each name is, as a mapping has it."""
    values: Mapping[str, tuple[float, ...]]
    """What these columns hold, by the same names."""
    suffix: str = ""
    """Of the file's name."""
    group: str = ""
    """The part of the file that holds them."""


@dataclass(frozen=True, kw_only=True)
class ImporterRecord(PluginRecord):
    """A reader of files of other programs: `factory(settings)`.

    The factory raises MissingPackageError if it needs a package that is not installed.
    """

    factory: Callable[[Any], Importer]
    """Makes the reader, of the settings."""
    examples: tuple[ImporterExample, ...] = ()
    """What the conformance kit holds it to, beside what is the same for every importer."""


@dataclass(frozen=True, kw_only=True)
class EventSinkRecord(PluginRecord):
    """A guarded listener to the events of a run: `factory(settings)`.

    A station names it under `listeners`. It has a thread of its own; one that raises, or does not
    keep up with the run, is dropped with an alarm.
    """

    factory: Callable[[Any], EventSink]
    """Makes the listener, of the settings."""


@dataclass(frozen=True, kw_only=True)
class StepRecord(PluginRecord):
    """A kind of step, under its name in procedures; its settings are StepSettings.

    `help` says in one line what it does; its model with its docstrings describes the keys. The
    schema for editors and the pages of the language are made of them.
    """

    factory: Callable[[Any, Any], None]
    """Plans it: `factory(settings, planning)` writes down each action by `planning`, a Planning."""
    example: str = ""
    """How it is written, in a line."""

    @property
    def steps_model(self) -> type[StepSettings]:
        """The model of the settings; PluginError if that is none of a step."""
        model = self.settings_model
        if not issubclass(model, StepSettings):
            raise PluginError(f"the settings of the step '{self.name}' are no StepSettings")
        return model


@dataclass(frozen=True, kw_only=True)
class UnitRecord(PluginRecord):
    """A unit of measurement: known wherever a quantity is written, under its symbol."""

    definition: UnitDefinition
    """The symbol, the kind of quantity with its dimension, and how large the unit is."""

    def factory(self, settings: Any) -> Unit:  # noqa: ARG002  (there are none)
        """Return the unit."""
        return self.definition.unit


@dataclass(frozen=True, kw_only=True)
class LabRecord(PluginRecord):
    """A lab folder to begin with, as `rigrunner init` makes it.

    Letterhead, reports and schemas are the same in every one; the rest is its own.
    """

    files: str
    """Where its own files stand, 'package:folder': station.yaml, README.md, plugins, procedures."""
    procedures: tuple[str, ...] = ()
    """Shipped procedures of which it gets a copy, in the order in which to run them."""

    def factory(self, settings: Any) -> Path:  # noqa: ARG002  (there are none)
        """Return the folder with its own files."""
        return _folder_at(self.files)


@dataclass(frozen=True, kw_only=True)
class KindRecord(PluginRecord):
    """A kind of plugin: whoever brings plugins of it has a function of the name `hook`.

    Its name is that of the kind, its help says what such a plugin is. The package that brings a
    kind uses the plugins of it, and says what they must keep to.
    """

    hook: str
    """What that function is called: 'rigrunner_' and a plural noun."""
    record: type[PluginRecord]
    """Of what it returns a list."""
    takes: tuple[str, ...] = ()
    """By which names that is called what a record's factory makes, if it is a function."""
    conformance: str = ""
    """The module, 'package.module', that has `CHECKS`, the checks of the conformance kit for such
    plugins, and `SUBJECT`, the class of `rigrunner_testing` that they are given."""
    template: str = ""
    """Of which files `rigrunner new` makes one: 'package:folder', where `KIND.py.jinja` and
    `test_KIND.py.jinja` stand."""

    def factory(self, settings: Any) -> type[PluginRecord]:  # noqa: ARG002  (there are none)
        """Return the type of its records."""
        return self.record

    @property
    def templates(self) -> Path:
        """The folder of these files."""
        return _folder_at(self.template)


class HookSpecs:
    """The hooks; each returns any number of records."""

    @hookspec
    def rigrunner_steps(self) -> Iterable[StepRecord]:
        """Return the kinds of steps that this plugin brings."""
        raise NotImplementedError

    @hookspec
    def rigrunner_devices(self) -> Iterable[DeviceRecord]:
        """Return the devices that this plugin brings."""
        raise NotImplementedError

    @hookspec
    def rigrunner_outlier_rules(self) -> Iterable[OutlierRuleRecord]:
        """Return the rules for gross errors that this plugin brings."""
        raise NotImplementedError

    @hookspec
    def rigrunner_fits(self) -> Iterable[FitRecord]:
        """Return the fits that this plugin brings."""
        raise NotImplementedError

    @hookspec
    def rigrunner_decision_rules(self) -> Iterable[DecisionRuleRecord]:
        """Return the decision rules that this plugin brings."""
        raise NotImplementedError

    @hookspec
    def rigrunner_analyses(self) -> Iterable[AnalysisRecord]:
        """Return the analyses of any quantity that this plugin brings."""
        raise NotImplementedError

    @hookspec
    def rigrunner_report_formats(self) -> Iterable[ReportFormatRecord]:
        """Return the report formats that this plugin brings."""
        raise NotImplementedError

    @hookspec
    def rigrunner_certificate_formats(self) -> Iterable[CertificateFormatRecord]:
        """Return the printed forms of certificates that this plugin brings."""
        raise NotImplementedError

    @hookspec
    def rigrunner_study_formats(self) -> Iterable[StudyFormatRecord]:
        """Return the formats of reports on many runs that this plugin brings."""
        raise NotImplementedError

    @hookspec
    def rigrunner_importers(self) -> Iterable[ImporterRecord]:
        """Return the readers of other programs' files that this plugin brings."""
        raise NotImplementedError

    @hookspec
    def rigrunner_event_sinks(self) -> Iterable[EventSinkRecord]:
        """Return the listeners to events that this plugin brings."""
        raise NotImplementedError

    @hookspec
    def rigrunner_labs(self) -> Iterable[LabRecord]:
        """Return the lab folders to begin with that this plugin brings."""
        raise NotImplementedError

    @hookspec
    def rigrunner_kinds(self) -> Iterable[KindRecord]:
        """Return the kinds of plugins that this plugin brings."""
        raise NotImplementedError

    @hookspec
    def rigrunner_units(self) -> Iterable[UnitRecord]:
        """Return the units of measurement that this plugin brings."""
        raise NotImplementedError


def _folder_at(place: str) -> Path:
    package, _, folder = place.partition(":")
    return Path(str(import_module(package).__file__)).parent / folder


def __getattr__(name: str) -> Any:
    return moved(__name__, name)


def _model_at(place: str) -> type[Settings]:
    module, _, name = place.partition(":")
    try:
        found = getattr(import_module(module), name)
    except (Exception, SystemExit) as error:
        reason = f"{type(error).__name__}: {error}"
        raise PluginError(f"the settings '{place}' cannot be loaded: {reason}") from error
    if not (isinstance(found, type) and issubclass(found, Settings)):
        raise PluginError(f"'{place}' is not a model of settings")
    return found
