"""Any file gives a tree, or a message with its location, in limited time."""

from __future__ import annotations

import contextlib
import json
import time
import tracemalloc

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from helpers_language import only_problem, problems_of
from helpers_thorough import examples
from rigrunner.api.errors import InvalidFileError
from rigrunner.yamlfile import parse, read


def refusal(text: str) -> str:
    return str(only_problem(parse, text, "f.yaml"))


@pytest.mark.parametrize(
    ("text", "start"),
    [
        ("a: 1\nb: 2\na: 3\n", "3:1: the key 'a' is given twice; first at f.yaml:1:1"),
        ("x:\n  - {a: 1, a: 2}\n", "2:12: x[0]: the key 'a' is given twice; first at f.yaml:2:6"),
        ("a: &b 1\n", "1:4: a: the anchor &b is not allowed"),
        ("a: *b\n", "1:4: a: the alias *b is not allowed"),
        ("a: !!python/object:os.system x\n", "1:4: a: the tag tag:yaml.org,2002:python/"),
        ("! a\n", "1:1: the tag ! is not allowed"),
        ("1: a\n", "1:1: the key 1 is not a text (put it in quotes: '1')"),
        ("x: {true: a}\n", "1:5: x: the key true is not a text"),
        ("~: a\n", "1:1: the key ~ is not a text"),
        ("010: a\n", "1:1: the key 010 is not a text"),
        ("? [a]\n: b\n", "1:3: a key has to be a text"),
        ("a: 1\n---\nb: 2\n", "2:1: a second document begins here"),
        ("", " the file is empty"),
        ("# nothing\n", " the file is empty"),
        ("a:\n\tb: 1\n", "2:1: a tab indents this line (indent with spaces)"),
        ("a: b\x00c\n", "1:5: the character U+0000 is not allowed in a text file"),
        ("a: 1\nb: \x1b[31m\n", "2:4: the character U+001B"),
        ("a: 'x\nb: 1\n", "3:1: not YAML: found unexpected end of stream"),
        ("a: [1, 2\nb: 3\n", "2:2: not YAML: did not find expected ',' or ']'"),
        ("a: b: c\n", "1:5: not YAML: mapping values are not allowed"),
        ("a: @b\n", "1:4: not YAML: found character that cannot start any token"),
        ("max: {a: 1,5 N}\n", "1:12: max: there is a decimal comma before '5 N'"),
        ("a: {window: 1,5}\n", "1:15: a: there is a decimal comma before '5'"),
        ("a: [1,5 N, 3 N]\n", "1:7: a: there is a decimal comma before '5 N'"),
    ],
)  # fmt: skip
def test_invalid_text_is_refused_with_location_and_message(text, start):
    assert refusal(text).startswith(f"f.yaml:{start}")


def test_unclosed_quote_is_located():
    assert "begins at f.yaml:2:4" in refusal("a: 1\nb: 'it\nc: 1\n")


@pytest.mark.parametrize("text", ["a: [1,5]", "a: [1 Hz,5 Hz]", "a: [1, 5 N]", "a: {b: 1, 5 N: 2}"])
def test_commas_between_values_are_not_taken_for_decimal_commas(text):
    parse(text, "f.yaml")


def test_all_problems_are_reported_at_once():
    problems = problems_of(parse, "a: 010\na: .nan\nb: &x 1\n", "f.yaml")

    assert [problem.location.line for problem in problems] == [1, 2, 2, 3]


def test_repeated_keys_refer_to_the_first():
    assert [p.message[-10:] for p in problems_of(parse, "a: 1\na: 2\na: 3\n", "f.yaml")] == [
        "f.yaml:1:1",
        "f.yaml:1:1",
    ]


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"[" * 50_000, "nested more than 40 deep"),
        (b"{a: " * 50_000, "nested more than 40 deep"),
        (b"- " * 400_000, "nested more than 40 deep"),
        (b"a: &a [x]\n" + b"".join(b"b%d: [*a]\n" % i for i in range(1000)), "more problems"),
        (b"a" * 1_000_001, "larger than 1,000,000 bytes"),
        ("é".encode() * 600_000, "larger than 1,000,000 bytes"),
        (b"[" + b"a," * 499_000 + b"]", "more than 20,000 values"),
        (b"a: 1\n" * 100_000, "more problems follow"),
        (b"a: '" + b"x" * 900_000, "unexpected end of stream"),
        (bytes(range(256)) * 1000, "is not UTF-8"),
        (b"\x89PNG\r\n\x1a\n" * 1000, "this is a picture, not a text file"),
        (b"PK\x03\x04" * 1000, "this is a ZIP archive or an office document, not a text file"),
        (b"%PDF-1.7\n%\xe2\xe3\xcf\xd3\n", "this is a PDF, not a text file"),
        (b"\x89HDF\r\n\x1a\n", "this is an HDF5 file, not a text file"),
        (b"\x00\x03", "U+0000 is not allowed in a text file"),
        ("a: 5 N·m".encode("latin-1"), "the byte 0xB7 is not UTF-8"),
        ("a: 1".encode("utf-16"), "the file is UTF-16, not UTF-8"),
    ],
)  # fmt: skip
def test_hostile_files_are_refused_in_limited_time(tmp_path, content, message):
    path = tmp_path / "hostile.yaml"
    path.write_bytes(content)

    start_s = time.process_time()
    problems = problems_of(read, path)

    assert time.process_time() - start_s < 10
    assert message in problems[-1].message
    assert problems[-1].location.file == str(path)


def test_huge_file_is_not_read_completely(tmp_path):
    path = tmp_path / "huge.yaml"
    with path.open("wb") as file:
        file.write(b"a: 1\n" * 1000)
        file.truncate(100_000_000)
    tracemalloc.start()

    assert only_problem(read, path).message == "the file is larger than 1,000,000 bytes"
    _, most_bytes = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert most_bytes < 10_000_000


def test_missing_file_cannot_be_read(tmp_path):
    problem = only_problem(read, tmp_path / "none.yaml")

    assert problem.message == "cannot be read: No such file or directory"


def test_folder_cannot_be_read(tmp_path):
    assert "cannot be read" in only_problem(read, tmp_path).message


@pytest.mark.parametrize(
    ("text", "hint"),
    [
        ("title: Gauge: points", "put a text that holds ': ' in quotes"),
        ("rule: simple\n  limits:", "check the indentation of this line and of the one before"),
    ],
)
def test_hint_of_an_unexpected_colon_states_its_cause(text, hint):
    assert hint in only_problem(parse, text, "f.yaml").hint


def test_byte_order_mark_and_dos_line_ends_are_read(tmp_path):
    path = tmp_path / "windows.yaml"
    path.write_bytes(b"\xef\xbb\xbfa: 1\r\nb: [2,\r\n  x]\r\n")
    document = read(path)

    assert document.data == {"a": 1, "b": [2, "x"]}
    assert str(document.where(("a",), key=True)) == f"{path}:1:1"
    assert str(document.where(("b", 1))) == f"{path}:3:3"


def test_where_counts_characters_of_keys_and_values():
    document = parse("µ: {größe: [ä, b]}\n", "f.yaml")

    assert str(document.where(("µ", "größe"), key=True)) == "f.yaml:1:5"
    assert str(document.where(("µ", "größe"))) == "f.yaml:1:12"
    assert str(document.where(("µ", "größe", 1))) == "f.yaml:1:16"
    assert str(document.where(("µ", "größe", 7, "x"))) == "f.yaml:1:12"


WORDS = st.text(st.characters(categories=["L", "N", "P", "S", "Zs"]) | st.sampled_from("\n\t"))
TREES = st.recursive(
    st.none()
    | st.booleans()
    | st.integers(-(10**9), 10**9)
    | st.floats(allow_nan=False, allow_infinity=False)
    | WORDS,
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(WORDS, inner, max_size=4),
    max_leaves=12,
)


@settings(max_examples=examples(150), deadline=None)
@given(TREES)
def test_json_round_trips(tree):
    text = json.dumps({"tree": tree}, ensure_ascii=False, indent=1)

    assert parse(text, "f.yaml").data == {"tree": tree}


@settings(max_examples=examples(300), deadline=None)
@given(st.text(alphabet="ab01 \n\t:-[]{},'\"#&*!|>%@`?.~\r\x85\u2028é", max_size=40))
@example("a: >-1x\n")
def test_any_text_is_read_or_refused_with_a_location(text):
    problems = ()
    try:
        parse(text, "f.yaml")
    except InvalidFileError as error:
        problems = error.problems
    assert all(problem.location.file == "f.yaml" for problem in problems)


@settings(max_examples=examples(200), deadline=None)
@given(st.binary(max_size=60))
def test_any_bytes_are_read_or_refused(tmp_path_factory, content):
    path = tmp_path_factory.getbasetemp() / "any.yaml"
    path.write_bytes(content)
    with contextlib.suppress(InvalidFileError):
        read(path)


@pytest.mark.parametrize(
    ("text", "hint"),
    [("a: {max: 1,5 N}", "'1.5 N'"), ("a: [0,05 N]", "'0.05 N'"), ("<<: {a: 1}", "$name")],
)
def test_hint_shows_the_intended_form(text, hint):
    (problem,) = problems_of(parse, text, "f.yaml")
    assert hint in problem.hint
