"""Examples on pages that no test runs are still correct: parts of files, and commands."""

from __future__ import annotations

import re
import shlex

import pytest
import yaml

from helpers_cli import call
from helpers_docs import ROOT, code_blocks, pages
from rigrunner.cli.lazy import LazyGroup
from rigrunner.cli.main import rigrunner
from rigrunner.procedure import load_procedure
from rigrunner.run.inputs import read_answers

PROCEDURE = ROOT / "procedures/starting_torque_1000n.yaml"
STATION = ROOT / "procedures/stations/simulated.yaml"
OF_STARTS = ROOT / "procedures/no_load_breakaway.yaml"
BENCH = ROOT / "procedures/stations/simulated_bench.yaml"
PART = "run by the reader alone: a part of a procedure"
OF_A_STATION = {"devices", "durability", "listeners", "safety", "instruments", "rig"}
OF_AN_ANALYSIS = "      "
"""The indentation of its keys."""
LANGUAGE = ROOT / "docs/reference/procedure-language.md"


def is_of_answers(block):
    return block.code.startswith("specimen: ")


def yaml_examples():
    """Return the YAML blocks that no command of their page uses."""
    return [
        pytest.param(block.code, id=f"{page.relative_to(ROOT)}:{block.line}")
        for page in pages()
        for block in code_blocks(page)
        if block.language == "yaml" and not block.file and block.elsewhere in {"", PART}
        if not is_of_answers(block)
    ]


def sections(text, indent=""):
    """Return a mapping's entries as they are written, by key."""
    parts = re.split(rf"^(?={indent}[\w]+:)", text, flags=re.MULTILINE)
    return {
        part.partition(":")[0].strip(): part for part in parts if re.match(rf"{indent}\w+:", part)
    }


def completed(part, whole):
    """Return a file with the sections of a part in place of its own."""
    if part.startswith(OF_AN_ANALYSIS):
        head, name, inner = sections(whole)["analysis"].split("\n", 2)
        inner = sections(inner, OF_AN_ANALYSIS) | sections(part, OF_AN_ANALYSIS)
        part = f"{head}\n{name}\n{''.join(inner.values())}"
    parts = sections(whole) | sections(part)
    if part.startswith("analysis:") and "template_inverse" not in part:
        del parts["acceptance"]  # its limit is for that method's torque
    if part.startswith("main:") and "- record:" not in part:
        del parts["analysis"], parts["acceptance"]  # nothing to analyse
    return "".join(parts.values())


def checked(procedure, station):
    # A checkout may have runs in its folder.
    runs = procedure.with_name("runs")
    called = call("check", procedure, "--station", station, "--runs", runs)
    assert called.code == 0, called.err
    return called.out


@pytest.mark.parametrize("part", yaml_examples())
def test_example_part_fits_into_a_complete_file(part, tmp_path):
    keys = set(yaml.safe_load(part))
    procedure, station = tmp_path / "procedure.yaml", tmp_path / "station.yaml"
    whole, bench = (OF_STARTS, BENCH) if "breakaway:" in part else (PROCEDURE, STATION)
    text = whole.read_text("utf-8")
    text = text.replace("$running_in", "10 rpm" if whole is OF_STARTS else "5 Hz")
    procedure.write_text(text, encoding="utf-8")
    station.write_text(bench.read_text("utf-8"), encoding="utf-8")
    changed = station if keys & OF_A_STATION or "station/1" in part else procedure
    changed.write_text(completed(part, changed.read_text("utf-8")), encoding="utf-8")
    checked(procedure, station)


def test_example_answers_fit_their_questions(tmp_path):
    blocks = code_blocks(LANGUAGE)
    (place,) = (place for place, block in enumerate(blocks) if is_of_answers(block))
    questions = "".join(
        block.code for block in reversed(blocks[:place]) if block.code.startswith("inputs:")
    )
    procedure, answers = tmp_path / "procedure.yaml", tmp_path / "answers.yaml"
    inputs = "".join(re.findall(r"^  \w+: {.*}\n", questions, re.MULTILINE))
    whole = PROCEDURE.read_text("utf-8")
    procedure.write_text(completed(f"inputs:\n{inputs}", whole), encoding="utf-8")
    answers.write_text(blocks[place].code, encoding="utf-8")
    read = read_answers(answers, load_procedure(procedure))
    assert read == yaml.safe_load(blocks[place].code)


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ("analysis:\n  - swing_torque: {fits: [polinomial]}\n", "polinomial"),
        ("      primary: energi\n", "energi"),
        ("acceptance:\n  limitt: {}\n", "limitt"),
        ("durability: {sync: never}\n", "never"),
    ],
)
def test_wrong_example_part_is_detected(wrong, words, tmp_path):
    with pytest.raises(AssertionError, match=words):
        test_example_part_fits_into_a_complete_file(wrong, tmp_path)


def commands():
    """Return the command lines on pages that no test runs."""
    for page in pages():
        for block in code_blocks(page):
            if block.language == "sh" and not block.elsewhere:
                continue
            text = block.code.replace("\\\n", " ")
            for line in re.findall(r"^(?:\S*/)?(?:rigrunner|python) .*", text, re.MULTILINE):
                yield pytest.param(line, id=f"{page.relative_to(ROOT)}:{block.line}")


@pytest.mark.parametrize("line", [*commands()])
def test_example_command_exists_with_its_options(line):
    words = shlex.split(line, comments=True)[1:]
    if words[0].endswith(".py"):
        assert (ROOT / words[0]).is_file()
    if "rigrunner" in line.split()[0]:
        command = rigrunner
        while isinstance(command, LazyGroup):
            command = command.get_command(None, words.pop(0))
            assert command is not None, line
        options = {option for param in command.params for option in param.opts}
        assert {word.partition("=")[0] for word in words if word.startswith("-")} <= options


def test_commands_are_in_fenced_blocks():
    """Four spaces make a block too, which no test reads."""
    indented = re.compile(r"^ {4}(?:rigrunner|python|pip|git|curl) ", re.MULTILINE)
    fenced = re.compile(r"^```.*?^```$", re.MULTILINE | re.DOTALL)
    for page in pages():
        assert not indented.search(fenced.sub("", page.read_text(encoding="utf-8"))), page


@pytest.mark.parametrize("page", sorted(ROOT.glob("docs/how-to/*.md")), ids=lambda page: page.stem)
def test_how_to_has_its_standard_beginning_and_end(page):
    text = page.read_text(encoding="utf-8")
    assert re.match(r"# .+\n\nYou \w+", text)
    title, _, what_you_see = text.rpartition("\n## ")[2].partition("\n\n")
    assert title == "What you see"
    assert what_you_see.strip()


GENERATED = re.compile(r"(?:Made|made) by `(?:docs/reference/|python -m)")
BELOW = "<!-- below: made by"


def test_site_has_at_most_45000_handwritten_words():
    """As `wc -w` counts them, with code blocks; generated text does not count."""
    off_the_site = {"decisions", "evidence", "dependencies.md"}
    word_counts = {
        page: len(text.partition(BELOW)[0].split())
        for page in ROOT.glob("docs/**/*.md")
        for text in [page.read_text(encoding="utf-8")]
        if not off_the_site & set(page.parts) and not GENERATED.search(text[:600])
    }
    assert len(word_counts) > 60
    assert sum(word_counts.values()) <= 45_000
