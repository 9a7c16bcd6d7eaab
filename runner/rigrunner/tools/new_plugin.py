"""Make a plugin that works at once: an installable package, or one file in a lab's folder."""

from __future__ import annotations

import ast
import keyword
import re
from collections import Counter
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from rigrunner import __version__
from rigrunner.api.errors import UsageError
from rigrunner.api.hooks import API_VERSION
from rigrunner.tools.new_files import write_new_files

if TYPE_CHECKING:
    from rigrunner.api.hooks import KindRecord
    from rigrunner.registry import Registry

TEMPLATE = Path(__file__).parent / "plugin_template"
KINDS = {
    "device": "device",
    "fit": "fit",
    "outlier-rule": "outlier_rule",
    "rule": "decision_rule",
    "analysis": "analysis",
    "importer": "importer",
    "report": "report_format",
    "step": "step",
    "unit": "unit",
}
"""Rigrunner's own kinds that can be made, by their word, with the registry's name."""
_DEPENDENCIES = {
    "numpy>=1.26": {"fit", "outlier_rule", "importer", "analysis"},
    "pydantic>=2.7": {"outlier_rule", "decision_rule"},
}
"""Beside Rigrunner, with the kinds whose template imports them."""
_LONGEST = 30
_NAME = re.compile(r"[a-z][a-z0-9]*(?:_[a-z0-9]+)*")
_YAML_WORDS = {"yes", "no", "true", "false", "on", "off", "null"}


@dataclass(frozen=True)
class NewPlugin:
    """A plugin to make."""

    word: str
    """The word of its kind: a key of KINDS, or the name of a kind that a package brings."""
    name: str
    kind_record: KindRecord | None = None
    """The kind, if a package brings it."""

    @property
    def kind(self) -> str:
        """The registry's name of the kind."""
        return self.kind_record.name if self.kind_record else KINDS[self.word]

    @property
    def project(self) -> str:
        """The name of the installed distribution."""
        return f"rigrunner-{self.name.replace('_', '-')}"

    @property
    def package(self) -> str:
        """The name of the imported package."""
        return f"rigrunner_{self.name}"

    def texts(self) -> dict[str, str]:
        """Return the files of its package, by name."""
        source, test = f"src/{self.package}", f"tests/test_{self.name}.py"
        templates = {
            "pyproject.toml": "pyproject.toml",
            "README.md": "README.md",
            f"{source}/__init__.py": f"{self.stem}.py",
            test: f"test_{self.stem}.py",
        }
        if self.kind == "device":
            templates |= {name: name for name in ("example/procedure.yaml", "example/station.yaml")}
        return {name: self._render(of) for name, of in templates.items()} | {
            f"{source}/py.typed": ""
        }

    def module(self) -> str:
        """Return the text of its module."""
        return self._render(f"{self.stem}.py")

    @property
    def stem(self) -> str:
        """The name of the templates of this kind."""
        return self.word.replace("-", "_")

    @property
    def article(self) -> str:
        """The article before its kind: "a unit", as it is said, but "an outlier rule"."""
        return "an" if self.word[0] in "aeio" else "a"

    def _render(self, template: str) -> str:
        environment = Environment(  # noqa: S701  (it writes Python and Markdown, no HTML)
            loader=FileSystemLoader(
                [TEMPLATE, *([self.kind_record.templates] if self.kind_record else [])]
            ),
            undefined=StrictUndefined,
            trim_blocks=True,
            lstrip_blocks=True,
            keep_trailing_newline=True,
        )
        major, minor = __version__.split(".")[:2]
        dependencies = [package for package, kinds in _DEPENDENCIES.items() if self.kind in kinds]
        dependencies.append(f"rigrunner>={major}.{minor},<{int(major) + 1}")
        return environment.get_template(f"{template}.jinja").render(
            name=self.name,
            title=self.name.replace("_", " ").capitalize(),
            class_name=self.class_name,
            project=self.project,
            package=self.package,
            kind=self.stem,
            registry_kind=self.kind,
            kind_words=self.word.replace("-", " "),
            article=self.article,
            api_version=API_VERSION,
            dependencies=", ".join(f'"{each}"' for each in dependencies),
        )

    @property
    def class_name(self) -> str:
        """The name of its class."""
        return "".join(part.capitalize() for part in self.name.split("_"))


def new_plugin(word: str, name: str, registry: Registry) -> NewPlugin:
    """Return a plugin to make, by the word of its kind; raise UsageError for an unknown word."""
    package_kinds = {kind.name.replace("_", "-"): kind for kind in registry.kinds if kind.template}
    if word not in (KINDS | package_kinds):
        raise UsageError(
            f"got the kind '{word}', expected one that can be made",
            hint=f"there are: {', '.join([*KINDS, *package_kinds])}",
        )
    return NewPlugin(word, name, package_kinds.get(word))


def make_package(plugin: NewPlugin, folder: Path, registry: Registry) -> list[str]:
    """Write an installable package and return its files; raise UsageError with nothing written."""
    _check(plugin, registry)
    if find_spec(plugin.package) is not None:
        raise UsageError(
            f"there is a package {plugin.package} already", hint="give the plugin another name"
        )
    return write_new_files(folder, plugin.texts())


def make_drop_in(plugin: NewPlugin, folder: Path, registry: Registry) -> list[str]:
    """Write one file into a lab's folder of plugins and return it; raise UsageError."""
    _check(plugin, registry)
    return write_new_files(folder, {f"{plugin.name}.py": plugin.module()})


def _check(plugin: NewPlugin, registry: Registry) -> None:
    name = plugin.name
    if len(name) > _LONGEST:
        raise UsageError(f"'{name}' has {len(name)} characters, expected at most {_LONGEST}")
    if not _NAME.fullmatch(name) or keyword.iskeyword(name) or name in _YAML_WORDS:
        words = re.findall(r"[^\W_]+", re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name).lower())
        usable = "_".join(words)
        near = f"such as '{usable}'" if _NAME.fullmatch(usable) and usable != name else ""
        raise UsageError(
            f"'{name}' cannot be the name of a plugin: small letters, digits and '_', a letter"
            " first, not a keyword of Python or YAML",
            hint=near,
        )
    key = (plugin.kind, name)
    existing = [each for each in registry.plugins if (each.kind, each.record.name) == key]
    if existing:
        raise UsageError(
            f"there is {plugin.article} {plugin.word} '{name}' already, of {existing[0].provider}",
            hint="give yours another name",
        )
    bound: Counter[str] = Counter()
    for node in ast.parse(plugin.module()).body:
        if isinstance(node, ast.ImportFrom):
            bound.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ClassDef | ast.FunctionDef):
            bound[node.name] += 1
    duplicates = [symbol for symbol, times in bound.items() if times > 1]
    if duplicates:
        raise UsageError(
            f"'{name}' would make a class {duplicates[0]}, and that name is taken",
            hint="give the plugin another name",
        )
