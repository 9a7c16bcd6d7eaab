"""Loads plugins from entry points and from the drop-in folder of a lab, in the same way.

A plugin that cannot be imported, or is made for another plugin API, is disabled with the reason. A
name that two plugins claim is refused when it is used, with both providers. Neither ends the
program.
"""

from __future__ import annotations

import hashlib
import importlib.util
import os
import re
import sys
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from traceback import extract_tb
from typing import TYPE_CHECKING

import pluggy

from rigrunner import __version__
from rigrunner.api.errors import PluginError, RigrunnerError
from rigrunner.api.hooks import (
    API_VERSION,
    OLDEST_API_VERSION,
    PROJECT,
    KindRecord,
    UnitRecord,
    hookspec,
)
from rigrunner.api.units import define
from rigrunner.registry.culprit import DROP_IN, culprit
from rigrunner.registry.installed import Installed, installed
from rigrunner.registry.lookup import DisabledPlugin, Plugin, Provider, Registry
from rigrunner.registry.records import check_hook_names, check_marked, checked_records

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterable, Iterator
    from importlib.metadata import EntryPoint
    from types import ModuleType

_OWN = Installed(PROJECT, "rigrunner.steps.hooks")
"""The parts of the language that are loaded as plugins."""
_IN_TEXT = re.compile(r"^api_version\b[^=\n]*=\s*(\d+)\s*(?:#.*)?$", re.MULTILINE)
"""The API version in the text of a module, for one that cannot be imported."""


def load_registry(entries: Iterable[EntryPoint] | None = None) -> Registry:
    """Return the registry of all installed plugins, built-in ones included.

    `entries` are the entry points to load; by default those of all distributions.
    """
    providers = installed() if entries is None else [Installed.of(entry) for entry in entries]
    sources = [
        _Source(
            Provider(provider.name, provider.version),
            provider.entry.load,
            partial(_text_of, provider.entry),
            provider.place,
        )
        for provider in (_OWN, *sorted(providers, key=lambda provider: provider.name))
    ]
    return _load(sources, Registry(()))


def with_drop_ins(registry: Registry, folder: Path) -> Registry:
    """Return the registry with the plugins in the folder of a lab: each `*.py` is one provider.

    A file is loaded by its path only; its version is the digest of its text. Names with a leading
    '_' are skipped. Raises PluginError if the folder does not exist.
    """
    if not folder.is_dir():
        raise PluginError(
            f"there is no plugin folder {folder}",
            hint="the station names it under plugins:, relative to its own folder",
        )
    if not os.access(folder, os.R_OK | os.X_OK):
        raise PluginError(
            f"no permission to read the plugin folder {folder}",
            hint="ask for permission to read it",
        )
    sources = []
    for path in sorted(folder.glob("*.py")):
        if path.name.startswith("_"):
            continue
        version = ""
        with suppress(OSError):  # the reason is reported where it is loaded
            version = f"sha256:{hashlib.sha256(path.read_bytes()).hexdigest()[:12]}"
        text = partial(path.read_text, "utf-8")
        sources.append(_Source(Provider(str(path), version), partial(_import_file, path), text))
    added = _load(sources, registry)
    return Registry((*registry.plugins, *added.plugins), (*registry.disabled, *added.disabled))


@dataclass(frozen=True)
class _Source:
    """The place from which a provider is loaded."""

    provider: Provider
    load: Callable[[], object]
    text: Callable[[], str]
    place: str = ""
    """The value of its entry point; '' for a file in the folder of a lab."""


def _load(sources: Iterable[_Source], registry: Registry) -> Registry:
    """Return the plugins of the sources, after their kinds of plugins."""
    plugins: list[Plugin] = []
    disabled: list[DisabledPlugin] = []

    @contextmanager
    def disabled_if_broken(source: _Source) -> Iterator[None]:
        try:
            yield
        except KeyboardInterrupt:
            raise
        except BaseException as error:  # noqa: BLE001  (a plugin may raise anything)
            disabled.append(_disabled(source, error))

    modules = []
    for source in sources:
        with disabled_if_broken(source):
            modules.append((source, _module(source)))
    # All kinds before the first plugin: one may be of a kind of a later provider.
    kinds = list(registry.kinds)
    for _, module in modules:
        kinds += _new_kinds(module, kinds)
    for source, module in modules:
        with disabled_if_broken(source):
            plugins += _plugins(source.provider, module, kinds)
    return Registry(plugins, disabled)


def _new_kinds(module: object, known_kinds: Collection[KindRecord]) -> list[KindRecord]:
    """Return the new kinds of a module; none of a broken module.

    Problems with a kind are reported when its plugins are used.
    """
    taken = {name for kind in known_kinds for name in (kind.name, kind.hook)}
    (kind,) = (kind for kind in known_kinds if kind.record is KindRecord)
    with suppress(Exception, SystemExit):
        return [
            record
            for hook in _implementations(module, [kind])[kind.name]
            for record in checked_records(kind, hook.function(), known_kinds)
            if isinstance(record, KindRecord) and taken.isdisjoint({record.name, record.hook})
        ]
    return []


def _module(source: _Source) -> object:
    """Import a provider; an unsupported API is reported before other reasons."""
    try:
        module = source.load()
    except Exception:
        declared = None
        with suppress(Exception):
            declared = _IN_TEXT.search(source.text())
        if declared is not None:
            _check_api_version(int(declared[1]))
        raise
    if source.place != _OWN.place:
        _check_api_version(getattr(module, "api_version", None))
    return module


def _disabled(source: _Source, error: BaseException) -> DisabledPlugin:
    """Return the problem, its place in the files of the plugin, and what to do."""
    text = ""
    with suppress(Exception):  # it only helps to guess which plugins are missing
        text = source.text()
    if isinstance(error, RigrunnerError):
        return DisabledPlugin(source.provider, str(error), error.hint, text)
    place, message = _place(error), " ".join(str(getattr(error, "message", error)).split())
    reason = f"{type(error).__name__}: {message}{f' ({place})' if place else ''}"
    return DisabledPlugin(source.provider, reason, _fix(source, error, place), text)


def _place(error: BaseException) -> str:
    """Return `file:line` in the code of the plugin, or else in what it called."""
    if isinstance(error, SyntaxError) and error.filename:
        return f"{error.filename}:{error.lineno}"
    # Without the import machinery, which calls the plugin.
    ours = (Path(__file__).parent, Path(pluggy.__file__).parent)
    frames = [
        frame
        for frame in extract_tb(error.__traceback__)
        if not frame.filename.startswith("<frozen ")
        and not any(map(Path(frame.filename).is_relative_to, ours))
    ]
    return culprit(error) or (f"{frames[-1].filename}:{frames[-1].lineno}" if frames else "")


def _fix(source: _Source, error: BaseException, place: str) -> str:
    if isinstance(error, ModuleNotFoundError) and error.name:
        package = error.name.partition(".")[0]
        if package == source.place.partition(":")[0].partition(".")[0]:
            return (
                f"its entry point in pyproject.toml names '{source.place}': name the module that"
                " has its hooks"
            )
        return f"install the package that brings '{package}', or correct the import"
    if getattr(error, "code", None) == "model-field-missing-annotation":
        return f"write the type of that setting, such as `gain: float = 5.0` ({place})"
    if not place and source.place:
        return f"its entry point in pyproject.toml names '{source.place}': is that right?"
    return f"correct {place}" if place else ""


def _implementations(
    module: object, kinds: Collection[KindRecord]
) -> dict[str, list[pluggy.HookImpl]]:
    """Return the hooks of a module by the kind of their plugins."""
    manager = pluggy.PluginManager(PROJECT)
    manager.add_hookspecs(type("Hooks", (), {kind.hook: _hook for kind in kinds}))
    manager.register(module)
    return {kind.name: getattr(manager.hook, kind.hook).get_hookimpls() for kind in kinds}


@hookspec
def _hook() -> None:
    """Specify the hook of any kind, which has no arguments: see `HookSpecs`."""


def _plugins(provider: Provider, module: object, kinds: Collection[KindRecord]) -> list[Plugin]:
    implementations = _implementations(module, kinds)
    check_hook_names(module, {kind.hook for kind in kinds})
    check_marked(module, {hook.function for hooks in implementations.values() for hook in hooks})
    if not any(implementations.values()):
        raise PluginError(
            "it brings nothing: no function of it is a hook",
            hint="are its hooks in another module? the entry point names the one that has them",
        )
    plugins = [
        Plugin(kind.name, record, provider)
        for kind in kinds
        for hook in implementations[kind.name]
        for record in checked_records(kind, hook.function(), kinds)
    ]
    records = [plugin.record for plugin in plugins]
    for record in records:
        if isinstance(record, KindRecord) and record not in kinds:
            raise PluginError(f"another plugin brings the kind '{record.name}' or {record.hook}")
    units = (record.definition for record in records if isinstance(record, UnitRecord))
    define(units, provider.name)
    return plugins


def _text_of(entry: EntryPoint) -> str:
    spec = importlib.util.find_spec(entry.module)
    return Path(spec.origin).read_text(encoding="utf-8") if spec and spec.origin else ""


def _import_file(path: Path) -> ModuleType:
    """Import a file by its path only."""
    # Two labs may have a file of one name.
    unique = hashlib.sha256(str(path.resolve()).encode()).hexdigest()[:12]
    name = f"{DROP_IN}{unique}_{path.stem}"
    spec = importlib.util.spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise PluginError(f"{path} cannot be loaded as a module")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # pydantic resolves annotations through it
    try:
        spec.loader.exec_module(module)
    except BaseException:
        del sys.modules[name]
        raise
    return module


def _check_api_version(declared: object) -> None:
    """Raise PluginError unless this Rigrunner supports the API."""
    if not isinstance(declared, int) or isinstance(declared, bool):
        raise PluginError(
            "it does not say for which plugin API it is made",
            hint=f"its module needs a line 'api_version = {API_VERSION}'",
        )
    text = f"it is made for plugin API {declared}, and Rigrunner {__version__} has {_supported()}"
    if declared > API_VERSION:
        raise PluginError(
            text,
            hint=f"update Rigrunner, or install a version of it for API {API_VERSION}",
        )
    if declared < OLDEST_API_VERSION:
        raise PluginError(
            text,
            hint=f"install a newer version of it, for API {_supported()}, or an older Rigrunner",
        )


def _supported() -> str:
    if OLDEST_API_VERSION == API_VERSION:
        return str(API_VERSION)
    return f"{OLDEST_API_VERSION} to {API_VERSION}"
