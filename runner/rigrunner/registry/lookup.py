"""Look-up of plugins by kind and name, and their construction."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from pathlib import PurePath
from typing import TYPE_CHECKING, Any, Protocol

from pydantic import ValidationError, create_model

from rigrunner.api.analysis import Requirements
from rigrunner.api.analysis_context import AnalysisContext
from rigrunner.api.errors import PluginError, RigrunnerError, did_you_mean
from rigrunner.api.fit_choice import chosen_fits
from rigrunner.api.hooks import (
    AnalysisRecord,
    DeviceRecord,
    KindRecord,
    needs_nothing,
)
from rigrunner.api.settings import MadeOfOthers, Reached, Settings, SimulableSettings
from rigrunner.api.units import QuantityError, unit
from rigrunner.registry.declared import declaration_problems
from rigrunner.registry.records import OWN_KINDS

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Sequence

    from rigrunner.api.analysis import Fit
    from rigrunner.api.data import RunData
    from rigrunner.api.devices import Device, DeviceContext
    from rigrunner.api.findings import LiveAnalysis, Objection, ResultDefinition
    from rigrunner.api.hooks import PluginRecord
    from rigrunner.api.planned import ExpectedReading, PlannedRun, PlanProblem


_FEW = 8
"""Greatest number of names listed beside a suggestion."""
_WRITES = {"report_format", "certificate_format", "study_format"}
"""Kinds whose factory returns a function that writes a file."""


@dataclass(frozen=True)
class Provider:
    """The origin of a plugin."""

    name: str
    version: str

    def __str__(self) -> str:
        """Return name and version."""
        return f"{self.name} {self.version}".strip()


@dataclass(frozen=True)
class Plugin:
    """One plugin with its kind and provider."""

    kind: str
    record: PluginRecord
    provider: Provider


@dataclass(frozen=True)
class DisabledPlugin:
    """A provider that could not be loaded, and why."""

    provider: Provider
    reason: str
    fix: str = ""
    """What to do about it, if known."""
    text: str = ""
    """Text of the file that could not be loaded; '' if unknown."""

    def __str__(self) -> str:
        """Return provider and reason."""
        return f"{self.provider}: {self.reason}"


class Tap(Protocol):
    """Placed between a device and its instrument, to record or replay exchanges."""

    def with_wire(self, context: DeviceContext) -> DeviceContext:
        """Return the context of a device whose exchanges all go over its wire."""
        ...

    def with_call_mark(self, device: Device, context: DeviceContext) -> Device:
        """Return such a device, with a mark of whether it is being called."""
        ...

    def at_calls(self, device: Device, context: DeviceContext) -> Device:
        """Return a stand-in for any other device, whose calls are the exchanges."""
        ...


class Registry:
    """All plugins by kind and name."""

    def __init__(self, plugins: Iterable[Plugin], disabled: Iterable[DisabledPlugin] = ()) -> None:
        self.plugins = tuple(sorted(plugins, key=lambda plugin: (plugin.kind, plugin.record.name)))
        self.disabled = tuple(disabled)
        self._by_name: dict[tuple[str, str], list[Plugin]] = defaultdict(list)
        for plugin in self.plugins:
            self._by_name[plugin.kind, plugin.record.name].append(plugin)

    @property
    def kinds(self) -> tuple[KindRecord, ...]:
        """All kinds of plugins: those of Rigrunner, then those of plugins."""
        records = (plugin.record for plugin in self.plugins)
        return (*OWN_KINDS, *(record for record in records if isinstance(record, KindRecord)))

    def names(self, kind: str) -> list[str]:
        """Return the sorted names of all plugins of a kind."""
        return [name for plugin_kind, name in self._by_name if plugin_kind == kind]

    def disabled_with(self, name: str) -> DisabledPlugin | None:
        """Return the provider that could not be loaded and seems to have a plugin of that name.

        It has this name, as the file of a lab's plugin does, or the name occurs in its text.
        """
        for plugin in self.disabled:
            has_name = PurePath(plugin.provider.name).stem.replace("-", "_") == name
            if has_name or f'"{name}"' in plugin.text or f"'{name}'" in plugin.text:
                return plugin
        return None

    def find(self, kind: str, name: str) -> Plugin:
        """Return the plugin of a kind and name; raise PluginError with a suggestion."""
        plugins = self._by_name.get((kind, name), [])
        if len(plugins) == 1:
            return plugins[0]
        what = kind.replace("_", " ")
        if plugins:
            providers = " and ".join(str(plugin.provider) for plugin in plugins)
            raise PluginError(
                f"the {what} '{name}' is provided twice, by {providers}",
                hint="uninstall or remove one of them; Rigrunner does not choose for you",
            )
        raise PluginError(
            f"there is no {what} '{name}'", hint=self.suggestion(name, self.names(kind))
        )

    def with_all_settings(self) -> Registry:
        """Return the registry with the settings of all plugins loaded.

        Plugins whose settings cannot be loaded are disabled with the reason.
        """
        plugins, disabled = [], list(self.disabled)
        for plugin in self.plugins:
            try:
                _ = plugin.record.settings_model
            except PluginError as error:
                what = f"{plugin.kind} '{plugin.record.name}': {error.message}"
                disabled.append(DisabledPlugin(plugin.provider, what))
            else:
                plugins.append(plugin)
        return Registry(plugins, disabled)

    def settings_of(self, kind: str, name: str) -> type[Settings]:
        """Return the settings model of a plugin; raise PluginError if it does not exist."""
        return self.find(kind, name).record.settings_model

    def rig_model(self) -> type[Settings]:
        """Return the keys that a station may have under `rig`: of all plugins, in order.

        Raises PluginError, naming both plugins, if two declare one key differently.
        """
        declared: dict[type[Settings], Plugin] = {}
        for plugin in self.plugins:
            model = plugin.record.rig_model
            if model is not None:
                declared.setdefault(model, plugin)
        owners: dict[str, tuple[Plugin, object]] = {}
        for model, plugin in declared.items():
            for key, field in model.model_fields.items():
                declaration = (field.annotation, field.metadata)
                other, other_declaration = owners.setdefault(key, (plugin, declaration))
                if other_declaration != declaration:
                    pair = f"{_description(other)} and {_description(plugin)}"
                    raise PluginError(f"the key '{key}' of a rig is declared twice, by {pair}")
        if len(declared) == 1:
            return next(iter(declared))
        doc = " ".join(model.__doc__ or "" for model in declared)
        return create_model("Rig", __base__=(*declared,) or Settings, __doc__=doc)

    def rig_of(self, kind: str, name: str) -> type[Settings] | None:
        """Return the keys of the rig of a plugin; raise PluginError if it does not exist."""
        return self.find(kind, name).record.rig_model

    def record(self, kind: str, name: str) -> PluginRecord:
        """Return the record of a plugin; raise PluginError if it does not exist."""
        return self.find(kind, name).record

    def definitions(
        self, name: str, settings: Mapping[str, Any], context: AnalysisContext | None = None
    ) -> tuple[ResultDefinition, ...]:
        """Return the results of an analysis from its settings; raise PluginError."""
        with self._analysis(name, settings, context) as (record, validated, last):
            definitions = tuple(record.yields(validated, *last))
        for definition in definitions:
            try:
                unit(definition.unit)
            except QuantityError as error:
                what = f"the analysis '{name}' yields '{definition.name}' in an {error.message}"
                raise PluginError(what, hint=error.hint) from error
        return definitions

    def objections(
        self, name: str, settings: Mapping[str, Any], units: Mapping[str, str]
    ) -> tuple[Objection, ...]:
        """Return settings that do not fit the units of the requirements; raise PluginError."""
        symbols = dict(units)
        for field, fit in chosen_fits(self.validated("analysis", name, settings)).items():
            with suppress(PluginError):  # reported by the check of the plugins
                parameters = self.requires("fit", fit.name, fit.settings).parameters
                symbols |= {f"{field}.{name}": symbol for name, symbol in parameters.items()}
        with self._analysis(name, settings) as (record, validated, _):
            return tuple(record.objections(validated, symbols))

    def partner_problems(
        self, name: str, settings: Mapping[str, Any], planned: PlannedRun, partner: RunData
    ) -> tuple[str, ...]:
        """Return what speaks against a partner run; raise PluginError."""
        with self._analysis(name, settings) as (record, validated, last):
            return tuple(record.partner_problems(validated, planned, partner, *last))

    def plan_problems(
        self, name: str, settings: Mapping[str, Any], planned: PlannedRun
    ) -> tuple[PlanProblem, ...]:
        """Return why an analysis cannot use what a run will measure; raise PluginError."""
        with self._analysis(name, settings) as (record, validated, last):
            return tuple(record.plan_problems(validated, planned, *last))

    def entering(
        self, name: str, settings: Mapping[str, Any], planned: PlannedRun
    ) -> tuple[str, ...] | None:
        """Return the channels whose values enter the results; raise PluginError.

        None for an analysis that does not say more than it requires.
        """
        with self._analysis(name, settings) as (record, validated, last):
            if record.entering is None:
                return None
            return tuple(record.entering(validated, planned, *last))

    def expects(
        self, name: str, settings: Mapping[str, Any], planned: PlannedRun
    ) -> tuple[ExpectedReading, ...]:
        """Return what channels will probably show; raise PluginError."""
        with self._analysis(name, settings) as (record, validated, last):
            return tuple(record.expects(validated, planned, *last))

    def live(
        self, name: str, settings: Mapping[str, Any], context: AnalysisContext | None = None
    ) -> LiveAnalysis | None:
        """Return the live view of an analysis, if it has one; raise PluginError."""
        with self._analysis(name, settings, context) as (record, validated, last):
            return None if record.live is None else record.live(validated, *last)

    def _context(
        self, record: PluginRecord, context: AnalysisContext | None
    ) -> tuple[AnalysisContext, ...]:
        """Return the arguments of an analysis after its settings: its context, if it needs one."""
        if isinstance(record, AnalysisRecord) and record.in_context:
            return (context or AnalysisContext(plugins=self),)
        return ()

    @contextmanager
    def _analysis(
        self, name: str, settings: Mapping[str, Any], context: AnalysisContext | None = None
    ) -> Iterator[tuple[AnalysisRecord, Settings, tuple[AnalysisContext, ...]]]:
        """Give the record of an analysis, its settings and its last arguments, for one call."""
        plugin, validated = self.find("analysis", name), self.validated("analysis", name, settings)
        record = plugin.record
        assert isinstance(record, AnalysisRecord)  # noqa: S101  (guaranteed by the kind)
        with _naming(plugin):
            yield record, validated, self._context(record, context)

    def revision(self, kind: str, name: str) -> int:
        """Return the revision of a plugin; raise PluginError if it does not exist."""
        return self.find(kind, name).record.revision

    def requires(self, kind: str, name: str, settings: Mapping[str, Any]) -> Requirements:
        """Return what a plugin requires of a run; raise PluginError."""
        record, validated = self.find(kind, name).record, self.validated(kind, name, settings)
        with _naming(self.find(kind, name)):
            requires = getattr(record, "requires", needs_nothing)
            requirements = requires(validated, *self._context(record, None))
            if not isinstance(requirements, Requirements):
                what = f"the {kind.replace('_', ' ')} '{name}' requires {requirements!r:.60}"
                raise PluginError(what, hint="return Requirements(channels=(...))")
            return requirements

    def make(
        self, kind: str, name: str, settings: Mapping[str, Any], context: Any = None, **fits: Fit
    ) -> Any:
        """Validate the settings and call the plugin's factory; raise PluginError.

        `context`: of a device, and of an analysis that asks for it. `fits`: those that the settings
        name; missing ones are made here.
        """
        plugin = self.find(kind, name)
        validated = self.validated(kind, name, settings)
        arguments = self._context(plugin.record, context) if kind == "analysis" else (context,)
        # A plugin without a context is called with its settings alone.
        arguments = arguments if any(arguments) else ()
        for field, fit in chosen_fits(validated).items():
            fits.setdefault(field, self.make("fit", fit.name, fit.settings))
        with _naming(plugin):
            product = plugin.record.factory(validated, *arguments, **fits)  # type: ignore[attr-defined]  # every kind has one
        if product is None and kind != "device":  # a device is checked further
            what = f"the factory of the {kind.replace('_', ' ')} '{name}' gave None"
            raise PluginError(what, hint="return what it makes: is there a `return`?")
        return _checked_writer(plugin, product) if kind in _WRITES else product

    def validated(self, kind: str, name: str, settings: Mapping[str, Any]) -> Settings:
        """Return the validated settings of a plugin; raise PluginError."""
        try:
            plain = dict(settings) if isinstance(settings, Mapping) else settings
            return self.settings_of(kind, name).model_validate(plain)
        except ValidationError as error:
            errors = [(".".join(map(str, entry["loc"])), entry["msg"]) for entry in error.errors()]
            problems = "; ".join(f"{where}: {what}" if where else what for where, what in errors)
            raise PluginError(f"{kind} '{name}': {problems}") from error

    def make_device(
        self,
        plugin: str,
        settings: Mapping[str, Any],
        context: DeviceContext,
        tap: Tap | None = None,
    ) -> Device:
        """Return a device that can make others of this registry; raise PluginError.

        A `wired` device, and those that it makes, have the tap at their wires; any other one at its
        calls.
        """
        record = self.find("device", plugin).record
        wired = isinstance(record, DeviceRecord) and record.wired
        inner_tap = tap if wired else None

        def make(part_plugin: str, part_settings: Mapping[str, Any], /, part: str = "") -> Device:
            inner = replace(context, role=f"{context.role}/{part}") if part else context
            return self.make_device(part_plugin, part_settings, inner, inner_tap)

        device_context = replace(context, make=make)
        if tap is None:
            return self._device(plugin, settings, device_context)
        if wired:
            return tap.with_call_mark(
                self._device(plugin, settings, tap.with_wire(device_context)), context
            )
        return tap.at_calls(self._device(plugin, settings, device_context), context)

    def _device(self, plugin: str, settings: Mapping[str, Any], context: DeviceContext) -> Device:
        device = self.make("device", plugin, settings, context)
        with _naming(self.find("device", plugin)):
            problems = tuple(declaration_problems(device))
        if problems:
            hint = f"report it to its author; see 'rigrunner check-plugin {plugin}'"
            raise PluginError(f"device '{plugin}': {'; '.join(problems)}", hint=hint)
        return device  # type: ignore[no-any-return]  # just checked

    def source(
        self, plugin: str, settings: Mapping[str, Any], channel: str
    ) -> tuple[str, Mapping[str, Any]]:
        """Return plugin and settings of the part of a composite device with a channel.

        The settings must be valid.
        """
        model = self.find("device", plugin).record.settings_model
        if issubclass(model, MadeOfOthers):
            source = model.model_validate(dict(settings)).source(channel)
            if source is not None:
                part, name = source
                return self.source(part.plugin, part.settings, name)
        return plugin, settings

    def is_simulated(self, plugin: str, settings: Mapping[str, Any]) -> bool:
        """Return whether a device is simulated; a composite one is if all its parts are.

        One that brings its own simulator is simulated if its settings say so.
        """
        record = self.find("device", plugin).record
        if issubclass(record.settings_model, MadeOfOthers):
            parts = record.settings_model.model_validate(dict(settings)).others().values()
            return all(self.is_simulated(part.plugin, part.settings) for part in parts)
        if issubclass(record.settings_model, SimulableSettings):
            return record.settings_model.model_validate(dict(settings)).simulated
        return isinstance(record, DeviceRecord) and record.simulated

    def physical_addresses(self, plugin: str, settings: Mapping[str, Any]) -> list[str]:
        """Return the addresses of a device from its settings; of a composite one, of all parts.

        Empty for a simulator, and for a plugin that states none.
        """
        if self.is_simulated(plugin, settings):
            return []
        model = self.settings_of("device", plugin).model_validate(dict(settings))
        if isinstance(model, MadeOfOthers):
            parts = model.others().values()
            return [
                address
                for part in parts
                for address in self.physical_addresses(part.plugin, part.settings)
            ]
        return list(model.physical_addresses()) if isinstance(model, Reached) else []

    def is_reopenable(self, plugin: str, settings: Mapping[str, Any]) -> bool:
        """Return whether a second process can open a device after the first one died.

        A composite one can be opened if all its parts can.
        """
        record = self.find("device", plugin).record
        if issubclass(record.settings_model, MadeOfOthers):
            parts = record.settings_model.model_validate(dict(settings)).others().values()
            if not all(self.is_reopenable(part.plugin, part.settings) for part in parts):
                return False
        return isinstance(record, DeviceRecord) and record.reopenable

    def suggestion(self, name: str, names: Sequence[str]) -> str:
        """Return a similar name, and providers that could not be loaded and may have it."""
        hint, listed = did_you_mean(name, names), f"there are: {', '.join(names) or 'none'}"
        if not hint or len(names) <= _FEW:
            hint = f"{hint} {listed}".lstrip()
        return "; ".join([*(f"disabled: {plugin}" for plugin in self.disabled), hint])


def _description(plugin: Plugin) -> str:
    return f"the {plugin.kind.replace('_', ' ')} '{plugin.record.name}' of {plugin.provider}"


def _checked_writer(plugin: Plugin, write: Callable[[Any], object]) -> Callable[[Any], bytes]:
    """Return the function of a format; raise PluginError if it does not return bytes."""

    def checked(document: Any) -> bytes:
        with _naming(plugin):
            content = write(document)
        if not isinstance(content, bytes):
            got, what = type(content).__name__, plugin.kind.replace("_", " ")
            hint = "a text becomes bytes by its encode('utf-8')"
            raise PluginError(
                f"the {what} '{plugin.record.name}' gave a {got}, expected bytes", hint=hint
            )
        return content

    return checked


@contextmanager
def _naming(plugin: Plugin) -> Iterator[None]:
    """Name the plugin in unexpected exceptions, and convert those that would end the program."""
    what = _description(plugin)
    try:
        yield
    except (RigrunnerError, KeyboardInterrupt):
        raise
    except Exception as error:
        error.add_note(f"in {what}")
        raise
    except BaseException as error:
        raise RuntimeError(f"{what} raised {type(error).__name__}({error})") from error
