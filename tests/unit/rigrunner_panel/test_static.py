"""The screen's files: texts in two languages, modules that parse, and the pure functions."""

from __future__ import annotations

import json
import re
import shutil
import struct
import subprocess
from pathlib import Path

import numpy as np
import pytest

import rigrunner_panel
from helpers_lacking import lacking
from rigrunner_panel.live.curves import frame
from unit.rigrunner_panel.helpers_node import running_node

ROOT = Path(__file__).parents[3]
STATIC = Path(rigrunner_panel.__file__).parent / "static"
MODULES = sorted(path.resolve() for path in (STATIC / "js").rglob("*.js"))
LITERAL = re.compile(r'"([a-z_]+(?:\.[a-zA-Z_]+)+|[a-z_]+)"')


def words(language):
    return json.loads((STATIC / "texts" / f"{language}.json").read_text(encoding="utf-8"))


def test_both_languages_have_the_same_keys_and_placeholders():
    english, german = words("en"), words("de")
    assert list(english) == list(german)
    for key, text in english.items():
        names, german_names = (
            sorted(re.findall(r"\{(?!article|list)(\w+)\}", language))  # German may omit these
            for language in (text, german[key])
        )
        assert german_names == names, key
        assert german[key].strip(), key


def test_german_server_texts_have_the_same_placeholders():
    sections = words("said.de")
    sentences = [pair for section in sections.values() for pair in section.items()]
    assert len(dict(sentences)) == len(sentences)
    for english, german in sentences:
        names, german_names = (
            sorted(re.findall(r"\{(?!article)(\w+)\}", sentence))  # German omits articles
            for sentence in (english, german)
        )
        assert german_names == names, english
        assert german.strip(), english
    assert not [key for key in words("en") if key.startswith("says.")]  # their former place


@pytest.mark.parametrize("language", ["en", "de"])
def test_label_of_cancel_is_unique(language):
    texts = words(language)
    others = {text for key, text in texts.items() if key != "dialog.cancel"}
    assert texts["dialog.cancel"] not in others


def test_no_text_is_unused_or_missing():
    code = "\n".join(path.read_text(encoding="utf-8") for path in MODULES)
    keys = set(words("en"))
    used_keys = set(re.findall(r'\bt\("([^"]+)"', code))
    assert used_keys <= keys
    literals = set(LITERAL.findall(code))
    prefixes = tuple(re.findall(r"`((?:\w+\.)+\w*)\$\{", code))
    tails = set(re.findall(r"`\$\{key\}\.(\w+)`", code))
    unused = {
        key
        for key in keys - literals
        if not key.startswith((*prefixes, "instead.")) and key.rpartition(".")[2] not in tails
    }
    assert unused == set()


def test_page_has_nothing_inline_and_no_foreign_addresses():
    page = (STATIC / "index.html").read_text(encoding="utf-8")
    assert not re.search(r"<style|\sstyle=|\son\w+=|<script(?![^>]*\ssrc=)", page)
    for path in [STATIC / "index.html", *MODULES, *sorted((STATIC / "css").glob("*.css"))]:
        text = path.read_text(encoding="utf-8")
        assert not re.search(r"https?://", text), path
        assert not re.search(r"\b(innerHTML|outerHTML|insertAdjacentHTML|eval)\b", text), path


@pytest.fixture(scope="module")
def scripts(tmp_path_factory):
    """Return a folder in which Node loads the scripts as modules."""
    if shutil.which("node") is None:
        lacking("BROWSER", "there is no Node.js")
    folder = tmp_path_factory.mktemp("static")
    shutil.copytree(STATIC / "js", folder / "js")
    (folder / "package.json").write_text('{"type": "module"}', encoding="utf-8")
    return folder


def test_every_module_parses(scripts):
    files = [str(path) for path in sorted(scripts.rglob("*.js"))]
    assert len(files) > 20
    program = (
        "import { SourceTextModule } from 'node:vm'; import { readFileSync } from 'node:fs';"
        f"for (const file of {json.dumps(files)})"
        " new SourceTextModule(readFileSync(file, 'utf8'), { identifier: file });"
    )
    words = ["node", "--experimental-vm-modules", "--input-type=module"]
    checked = subprocess.run(
        words, input=program, capture_output=True, text=True, check=False, timeout=60
    )
    assert checked.returncode == 0, checked.stderr


@pytest.fixture(scope="module")
def evaluate(scripts):
    """Return a function that evaluates an expression of a module `m`, which it loads anew."""
    program = """
      let loads = 0;
      const answer = async ([module, expression]) => {
        const m = await import(`./js/${module}.js?${loads += 1}`);
        return new Function('m', `return (${expression});`)(m);
      };
    """
    with running_node(scripts, program) as ask:
        yield lambda module, expression: ask([module, expression])


@pytest.mark.parametrize(
    ("expression", "expected"),
    [
        # two significant digits of the uncertainty (GUM 7.2.6)
        ("m.withUncertainty(0.72613, 0.00948, 'N·m')", "0.7261 ± 0.0095 N·m"),
        ("m.withUncertainty(0.72613, 0.00996, 'N·m')", "0.726 ± 0.010 N·m"),
        ("m.withUncertainty(12.3456, 3.21, 'N·m')", "12.3 ± 3.2 N·m"),
        ("m.withUncertainty(123.4, 12.6, 'N·m')", "123 ± 13 N·m"),
        ("m.withUncertainty(0.5, null, 'N·m')", "0.5 N·m"),
        ("m.withUncertainty(null, 0.1, 'N·m')", "\u2013"),
        ("m.fixed(-1.25, 1)", "\u22121.3"),
        ("m.fixed(-0.0001, 2)", "0.00"),
        ("m.fixed(NaN, 2)", "\u2013"),
        ("m.duration(3725.4)", "1:02:05"),
        ("m.duration(59.6)", "1:00"),
        ("m.duration(-3)", "0:00"),
        ("m.bytes(999)", "999 B"),
        ("m.bytes(663000)", "663 kB"),
        ("m.bytes(79100000000)", "79.1 GB"),
    ],
)
def test_numbers_are_formatted_for_people(evaluate, expression, expected):
    assert evaluate("format", expression) == expected


def test_screen_decodes_frames_of_the_server(evaluate):
    content = frame(
        {"kind": "curve", "recording": "ä", "t_s": 1.5},
        {"x": np.array([1.5, -2.25]), "y": np.array([0.5])},
    )
    assert struct.unpack_from("<I", content)[0] % 4 == 0
    buffer = f"new Uint8Array({list(content)}).buffer"
    read = evaluate(
        "link",
        f"(f => ({{...f, curves: Object.fromEntries("
        f"Object.entries(f.curves).map(([k, v]) => [k, [...v]]))}}))(m.decodeFrame({buffer}))",
    )
    assert (read["kind"], read["recording"], read["t_s"]) == ("curve", "ä", 1.5)
    assert read["curves"] == {"x": [1.5, -2.25], "y": [0.5]}


def test_trend_columns_are_joined_filled_and_bounded(evaluate):
    expression = """(() => {
      const frame = (first, low, high) => ({ first, step_s: 0.1, reset: false,
        channel: "a.b", unit: "V",
        curves: { minimum: low, maximum: high } });
      let trend = { first: 0, stepS: 1, minimum: [], maximum: [] };
      trend = m.joined(trend, frame(0, [1, 2], [3, 4]));
      trend = m.joined(trend, frame(1, [-2, 5], [9, 6]));
      const early = JSON.parse(JSON.stringify(trend));
      const many = Array.from({ length: 1500 }, (_, i) => i);
      trend = m.joined(trend, frame(3, many, many));
      return { early, length: trend.minimum.length, first: trend.first,
        last: trend.maximum.at(-1), start: trend.minimum[0] };
    })()"""
    read = evaluate("store", expression)
    expected = {"first": 0, "stepS": 0.1, "channel": "a.b", "unit": "V", "minimum": [1, -2, 5]}
    assert read["early"] == {**expected, "maximum": [3, 9, 6]}
    assert (read["length"], read["first"]) == (1200, 303)
    assert (read["start"], read["last"]) == (300, 1499)


def test_scripts_have_no_circular_imports():
    imports = {
        path: {
            (path.parent / name).resolve()
            for name in re.findall(r'from "(\.[^"]+)"', path.read_text(encoding="utf-8"))
        }
        for path in MODULES
    }
    assert sum(map(len, imports.values())) > len(MODULES)
    while leaves := [path for path, names in imports.items() if not names & imports.keys()]:
        for path in leaves:
            del imports[path]
    assert [path.name for path in imports] == []


@pytest.mark.parametrize(("job", "stays"), [("{run: 'A', title: 'x'}", True), ("{run: ''}", False)])
def test_curve_is_cleared_by_another_job(evaluate, job, stays):
    calls = (
        "m.takeState({job: {run: 'A'}})",
        "m.takeFrame({kind: 'curve', recording: '001'})",
        f"m.takeChanges(2, {{job: {job}}})",
        "m.store.lastCurve !== null",
    )
    assert evaluate("store", f"({', '.join(calls)})") is stays


@pytest.mark.parametrize(
    ("text", "place"),
    [
        ("", {"path": [], "kind": "key", "word": ""}),
        ("id: x\nti", {"path": [], "kind": "key", "word": "ti"}),
        ("rule: gua", {"path": ["rule"], "kind": "value", "word": "gua"}),
        ("main:\n  - se", {"path": ["main", 0], "kind": "key", "word": "se"}),
        ("main:\n- a: 1\n- ", {"path": ["main", 1], "kind": "key", "word": ""}),
        ("main:\n- a: 1\nx", {"path": [], "kind": "key", "word": "x"}),
        ("m:\n  - s:\n      over: $f\n      ", {"path": ["m", 0, "s"], "kind": "key", "word": ""}),
        ("m: {a: [p, q", {"path": ["m", "a", 1], "kind": "value", "word": "q"}),
        ("m: {a: [p, q], b", {"path": ["m"], "kind": "key", "word": "b"}),
        ("m: {a: {b: 1},\n  c: d", {"path": ["m", "c"], "kind": "value", "word": "d"}),
        ("m: {a: 'x: {', b", {"path": ["m"], "kind": "key", "word": "b"}),
        ("a: |\n  b: {\n  c\nd", {"path": [], "kind": "key", "word": "d"}),
        ("a: |\n  b", None),
        ("a: # b", None),
        ("  # b", None),
        ("a: [1, # b", None),
        ("a: [1, # {\n  2", {"path": ["a", 1], "kind": "value", "word": "2"}),
        ('"a b": {c: ', {"path": ["a b", "c"], "kind": "value", "word": ""}),
    ],
)
def test_editor_finds_the_place_in_a_text(evaluate, text, place):
    assert evaluate("editor/place", f"m.placeAt({json.dumps(text)})") == place


SCHEMA = json.dumps(
    {
        "$defs": {
            "Step": {
                "type": "object",
                "properties": {
                    "wait": {"$ref": "#/$defs/Wait", "description": "Time passes."},
                    "set": {"type": "object", "patternProperties": {"^[a-z]+$": {"enum": ["x"]}}},
                },
            },
            "Wait": {
                "type": "object",
                "properties": {"time": {"type": "string", "description": "How long."}},
                "required": ["time"],
            },
        },
        "type": "object",
        "required": ["rule"],
        "properties": {
            "main": {"type": "array", "items": {"$ref": "#/$defs/Step"}},
            "rule": {"anyOf": [{"enum": ["u", "v"], "enumDescriptions": ["U.", "V."]},
                               {"type": "object", "properties": {"u": {"type": "object"}}}]},
        },
    }
)  # fmt: skip


@pytest.mark.parametrize(
    ("path", "kind", "labels"),
    [
        ([], "key", ["main", "rule"]),
        (["main"], "key", ["wait", "set"]),
        (["main", 3], "key", ["wait", "set"]),
        (["main", 0, "wait"], "key", ["time"]),
        (["main", 0, "set", "load"], "value", ["x"]),
        (["main", 0, "set", "LOAD"], "value", []),
        (["rule"], "value", ["u", "v", "u"]),
        (["none", 1, "such"], "key", []),
    ],
)
def test_completions_follow_the_schema(evaluate, path, kind, labels):
    place = json.dumps({"path": path, "kind": kind})
    shown = f"m.offered({SCHEMA}, {place}).map(({{ label }}) => label)"
    assert evaluate("editor/schema", shown) == labels


def test_completion_of_a_key_has_required_keys_and_help(evaluate):
    place = json.dumps({"path": ["main", 0], "kind": "key"})
    first = evaluate("editor/schema", f"m.offered({SCHEMA}, {place})[0]")
    assert (first["needed"], first["description"]) == (["time"], "Time passes.")
    expression = f"m.explained({SCHEMA}, {place}, 'wait')"
    assert evaluate("editor/schema", expression) == "Time passes."
    rule = json.dumps({"path": ["rule"], "kind": "value"})
    assert evaluate("editor/schema", f"m.explained({SCHEMA}, {rule}, 'v')") == "V."


def test_editor_bundle_exports_what_is_used_and_pins_its_packages():
    source = ROOT / ".ci/codemirror"
    pinned = json.loads((source / "package.json").read_text(encoding="utf-8"))["devDependencies"]
    locked = json.loads((source / "package-lock.json").read_text(encoding="utf-8"))
    for name, version in pinned.items():
        assert locked["packages"][f"node_modules/{name}"]["version"] == version
    folder = STATIC / "vendor/codemirror"
    assert "MIT License" in (folder / "LICENSE").read_text(encoding="utf-8")
    used = re.search(r"import \{([^}]*)\}", (STATIC / "js/editor/editor.js").read_text("utf-8"))[1]
    built = (folder / "codemirror.js").read_text(encoding="utf-8")
    exported = set(re.findall(r"\b\w+(?=[,}])", built[built.rindex("export{") :]))
    assert {name.strip() for name in used.split(",") if name.strip()} <= exported


AMEND = (
    "amend it ('rigrunner amend'), or issue a further copy, with a reason (--further-copy REASON)"
)


@pytest.mark.parametrize(
    ("language", "advice"),
    [
        ("en", "amend it under Certificates, or give the reason for a further copy"),
        ("de", "unter Zertifikate ändern, oder den Grund für eine weitere Ausfertigung angeben"),
    ],
)
def test_command_line_advice_is_reworded_for_the_screen(evaluate, language, advice):
    english, chosen = json.dumps(words("en")), json.dumps(words(language))
    say = "m.advice(en)" if language == "en" else f"m.translator({{}}, en, {chosen})"
    shown = f"((en) => [{json.dumps(AMEND)}, 'no advice'].map({say}))({english})"
    assert evaluate("said", shown) == [advice, "no advice"]


def test_reworded_advice_exists_in_the_program():
    sources = [
        path.read_text(encoding="utf-8")
        for package in ("rigrunner", "rigrunner_panel", "rigrunner_fleet")
        for path in (ROOT / "runner" / package).rglob("*.py")
    ]
    joined = re.sub(r'"\s*f?"', "", "\n".join(sources))
    english = words("en")
    advice = {key for key in english if key.startswith("instead.") and key.endswith(".of")}
    assert len(advice) >= 10
    for key in advice:
        literal = max(re.split(r"\{\w+\}", english[key]), key=len)
        assert literal in joined, key
        assert not re.search(r"rigrunner \w|--\w", english[key.removesuffix(".of")])
