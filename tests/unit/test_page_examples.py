"""What pages show and nobody runs is right all the same: parts of files, and commands."""

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
"""What its keys stand behind."""
LANGUAGE = ROOT / "docs/reference/procedure-language.md"


def is_of_answers(block):
    return block.code.startswith("specimen: ")


def shown():
    """Return the blocks of YAML that no command of their page uses."""
    return [
        pytest.param(block.code, id=f"{page.relative_to(ROOT)}:{block.line}")
        for page in pages()
        for block in code_blocks(page)
        if block.language == "yaml" and not block.file and block.elsewhere in {"", PART}
        if not is_of_answers(block)
    ]


def sections(text, indent=""):
    """Return a mapping's entries as they are written, by key."""
    found = re.split(rf"^(?={indent}[\w]+:)", text, flags=re.MULTILINE)
    return {
        part.partition(":")[0].strip(): part for part in found if re.match(rf"{indent}\w+:", part)
    }


def completed(part, whole):
    """Return a file with the sections of a part in place of its own."""
    if part.startswith(OF_AN_ANALYSIS):
        head, name, inner = sections(whole)["analysis"].split("\n", 2)
        inner = sections(inner, OF_AN_ANALYSIS) | sections(part, OF_AN_ANALYSIS)
        part = f"{head}\n{name}\n{''.join(inner.values())}"
    found = sections(whole) | sections(part)
    if part.startswith("analysis:") and "template_inverse" not in part:
        del found["acceptance"]  # its limit is for that method's torque
    if part.startswith("main:") and "- record:" not in part:
        del found["analysis"], found["acceptance"]  # there is nothing that it could analyse
    return "".join(found.values())


def checked(procedure, station):
    # The reader of a checkout may have runs in it.
    runs = procedure.with_name("runs")
    called = call("check", procedure, "--station", station, "--runs", runs)
    assert called.code == 0, called.err
    return called.out


@pytest.mark.parametrize("part", shown())
def test_a_part_of_a_file_fits_into_a_whole_one(part, tmp_path):
    known = set(yaml.safe_load(part))
    procedure, station = tmp_path / "procedure.yaml", tmp_path / "station.yaml"
    whole, bench = (OF_STARTS, BENCH) if "breakaway:" in part else (PROCEDURE, STATION)
    text = whole.read_text("utf-8")
    text = text.replace("$running_in", "10 rpm" if whole is OF_STARTS else "5 Hz")
    procedure.write_text(text, encoding="utf-8")
    station.write_text(bench.read_text("utf-8"), encoding="utf-8")
    changed = station if known & OF_A_STATION or "station/1" in part else procedure
    changed.write_text(completed(part, changed.read_text("utf-8")), encoding="utf-8")
    checked(procedure, station)


def test_the_answers_that_are_shown_fit_the_questions_before_them(tmp_path):
    blocks = code_blocks(LANGUAGE)
    (place,) = (place for place, block in enumerate(blocks) if is_of_answers(block))
    asked = "".join(
        block.code for block in reversed(blocks[:place]) if block.code.startswith("inputs:")
    )
    procedure, answers = tmp_path / "procedure.yaml", tmp_path / "answers.yaml"
    known = "".join(re.findall(r"^  \w+: {.*}\n", asked, re.MULTILINE))
    whole = PROCEDURE.read_text("utf-8")
    procedure.write_text(completed(f"inputs:\n{known}", whole), encoding="utf-8")
    answers.write_text(blocks[place].code, encoding="utf-8")
    found = read_answers(answers, load_procedure(procedure))
    assert found == yaml.safe_load(blocks[place].code)


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ("analysis:\n  - swing_torque: {fits: [polinomial]}\n", "polinomial"),
        ("      primary: energi\n", "energi"),
        ("acceptance:\n  limitt: {}\n", "limitt"),
        ("durability: {sync: never}\n", "never"),
    ],
)
def test_a_part_that_is_wrong_is_seen(wrong, words, tmp_path):
    with pytest.raises(AssertionError, match=words):
        test_a_part_of_a_file_fits_into_a_whole_one(wrong, tmp_path)


def commands():
    """Return the lines with which pages call the program, where no test calls it so."""
    for page in pages():
        for block in code_blocks(page):
            if block.language == "sh" and not block.elsewhere:
                continue
            text = block.code.replace("\\\n", " ")
            for line in re.findall(r"^(?:\S*/)?(?:rigrunner|python) .*", text, re.MULTILINE):
                yield pytest.param(line, id=f"{page.relative_to(ROOT)}:{block.line}")


@pytest.mark.parametrize("line", [*commands()])
def test_a_command_that_is_shown_is_one_with_these_options(line):
    words = shlex.split(line, comments=True)[1:]
    if words[0].endswith(".py"):
        assert (ROOT / words[0]).is_file()
    if "rigrunner" in line.split()[0]:
        command = rigrunner
        while isinstance(command, LazyGroup):
            command = command.get_command(None, words.pop(0))
            assert command is not None, line
        taken = {option for each in command.params for option in each.opts}
        assert {word.partition("=")[0] for word in words if word.startswith("-")} <= taken


def test_a_command_is_in_a_block_so_that_it_is_found():
    """Four blanks make a block as well, which no test reads."""
    beyond = re.compile(r"^ {4}(?:rigrunner|python|pip|git|curl) ", re.MULTILINE)
    fenced = re.compile(r"^```.*?^```$", re.MULTILINE | re.DOTALL)
    for page in pages():
        assert not beyond.search(fenced.sub("", page.read_text(encoding="utf-8"))), page


@pytest.mark.parametrize("page", sorted(ROOT.glob("docs/how-to/*.md")), ids=lambda page: page.stem)
def test_a_how_to_begins_with_what_it_achieves_and_ends_with_what_one_sees(page):
    text = page.read_text(encoding="utf-8")
    assert re.match(r"# .+\n\nYou \w+", text)
    title, _, seen = text.rpartition("\n## ")[2].partition("\n\n")
    assert title == "What you see"
    assert seen.strip()


GENERATED = re.compile(r"(?:Made|made) by `(?:docs/reference/|python -m)")
BELOW = "<!-- below: made by"


def test_the_site_has_at_most_45000_words_that_people_wrote():
    """As `wc -w` counts them, with code blocks; what is generated is apart."""
    off_the_site = {"decisions", "evidence", "dependencies.md"}
    written = {
        page: len(text.partition(BELOW)[0].split())
        for page in ROOT.glob("docs/**/*.md")
        for text in [page.read_text(encoding="utf-8")]
        if not off_the_site & set(page.parts) and not GENERATED.search(text[:600])
    }
    assert len(written) > 60
    assert sum(written.values()) <= 45_000
