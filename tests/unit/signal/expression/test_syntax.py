"""A formula is parsed to a tree or refused with its column; it is never executed."""

from __future__ import annotations

import time

import pytest

from rigrunner.signal.expression.syntax import (
    DEEPEST,
    FUNCTIONS,
    ExpressionError,
    Name,
    Number,
    Operation,
    parse,
)

NAMES = {"x", "b1", "b2", "T0"}


def test_formula_is_parsed_to_a_tree_with_columns():
    assert parse(" b1*(1 - exp(-x))", NAMES).root == Operation(
        "*",
        (
            Name("b1", 2),
            Operation(
                "-",
                (Number(1.0, 6), Operation("exp", (Operation("-", (Name("x", 15),), 14),), 10)),
                6,
            ),
        ),
        2,
    )


def test_powers_bind_as_in_mathematics():
    """-x**2 is -(x²), and x**b1**b2 is x^(b1^b2)."""
    assert parse("-x**2", NAMES).root == Operation(
        "-", (Operation("**", (Name("x", 2), Number(2.0, 5)), 2),), 1
    )
    power = parse("x**b1**b2", NAMES).root
    assert power.operands[1] == Operation("**", (Name("b1", 4), Name("b2", 8)), 4)


def test_names_of_a_formula():
    assert parse("b1 + pi*x - sqrt(x)\n + 2", NAMES).names() == {"b1", "x"}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "column 1: the end is not understood here"),
        ("b1 +", "column 5: the end is not understood"),
        ("b1 * / x", "column 6: '/' is not understood"),
        ("b1*x)", "column 5: '\\)' is not understood"),
        ("y + 1", "column 1: 'y' is not known .*known are T0, b1, b2, pi, x"),
        ("b1*TO", "column 4: 'TO' is not known .did you mean 'T0'"),
        ("exp + x", "column 1: 'exp' is a function .write exp"),
        ("sine(x)", "column 1: 'sine' is not a function .did you mean 'sin'"),
        ("b1(x)", "column 1: 'b1' is a quantity, not a function"),
        ("1 + exp(x, b1)", "column 5: 'exp' takes one number, not 2"),
        ("exp()", "takes one number, not 0"),
        ("x*atan2(x)", "column 3: 'atan2' takes two numbers, not 1"),
        ("max()", "takes at least one number, not 0"),
        ("min + x", "column 1: 'min' is a function"),
        ("2x", "column 2: 'x' follows a number .write \\* between"),
        ("0x10", "column 2: 'x10' follows a number"),
        ("1_000", "follows a number"),
        ("1.2.3", "column 4: '.' follows a number"),
        ("1,5*x", "column 1: '1' begins a Tuple"),
        ("x^2", "column 2: '\\^' is not allowed .write \\*\\*"),
        ("exp[-x]", "column 4: '\\[' is not allowed .write \\("),
        ("x // 2", "column 1: 'x' begins an operation that is not allowed"),
        ("x - - -", "the end is not understood"),
    ],
)
def test_mistakes_are_refused_with_their_column(text, message):
    with pytest.raises(ExpressionError, match=message):
        parse(text, NAMES)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("x.real", "column 2: the character '.' .FULL STOP. is not allowed"),
        ("().__class__", "column 3: the character '.'"),
        ("__import__('os')", "column 1: the character '_' .LOW LINE."),
        ("exp('x')", "column 5: the character ''' .APOSTROPHE."),
        ("x[0]", "column 2: '\\[' is not allowed"),
        ("lambda: x", "column 1: 'lambda' is a reserved word"),
        ("x if x else b1", "column 3: 'if' is a reserved word"),
        ("True", "column 1: 'True' is a reserved word"),
        ("exp(*x)", "column 5: '\\*' begins a Starred"),
        ("exp(x=1)", "column 6: the character '='"),
        ("exp(x)(x)", "column 1: 'exp' begins a Call"),
        ("(x := 1)", "column 4: the character ':'"),
        ("x; x", "column 2: the character ';'"),
        ("x # b1", "column 3: the character '#'"),
        ("x\\\nb1", "column 2: the character"),
        ("{x}", "column 1: '{' is not allowed"),
        ("x < 1", "column 3: the character '<'"),
        ("x @ x", "column 3: the character '@'"),
        ("eval(x)", "column 1: 'eval' is not a function"),
        ("1j", "column 2: 'j' follows a number"),
        ("b1*\u0445", "column 4: the character '\u0445' .CYRILLIC SMALL LETTER HA. is not allowed"),
        ("\uff581 + x", "column 1: the character .*FULLWIDTH LATIN SMALL LETTER X"),
        ("x\u00b2", "column 2: '\u00b2' is not allowed .write \\*\\*2"),
        ("b1 \u2212 x", "column 4: '\u2212' is not allowed .write -"),
        ("x\u200b", "column 2: the character .ZERO WIDTH SPACE."),
        ("x\x00", "column 2: the character .U.0000."),
        ("x**1000000", "column 4: '1000000' is a power out of range .-100 to 100"),
        ("x**-(1e9)", "is a power out of range"),
        ("9**9**9**9", "column 7: '9' is a power of numbers within a power"),
        ("9" * 400, "column 1: '9+' is too large a number"),
        ("1e999", "is too large a number"),
        ("+".join(["x"] * 10**5), "the formula has 199999 characters"),
        ("-" * 10**5 + "x", "the formula has 100001 characters"),
        ("+".join(["x"] * 500), "nested too deeply"),
        ("-" * 1900 + "x", "nested too deeply"),
        ("(" * 900 + "x" + ")" * 900, "nested too deeply"),
        ("exp(" * 390 + "x" + ")" * 390, "nested too deeply"),
        ("x**" * 600 + "x", "nested too deeply"),
    ],
)
def test_hostile_formulas_are_refused_quickly(text, message):
    began = time.process_time()
    with pytest.raises(ExpressionError, match=message):
        parse(text, NAMES)
    assert time.process_time() - began < 10


def test_deepest_allowed_nesting():
    parse("+".join(["x"] * (DEEPEST + 1)), NAMES)
    with pytest.raises(ExpressionError, match="column 1: nested too deeply"):
        parse("+".join(["x"] * (DEEPEST + 2)), NAMES)


@pytest.mark.parametrize("name", FUNCTIONS)
def test_every_function_is_parsed(name):
    assert parse(f"{name}(x)", NAMES).root == Operation(name, (Name("x", len(name) + 2),), 1)
