"""`rigrunner fit`: certified data sets as CSV files, and mistakes with their place."""

from __future__ import annotations

import csv
import json
import runpy

import numpy as np
import pytest

from helpers_cli import call
from helpers_docs import ROOT

strd = runpy.run_path(str(ROOT / "docs/evidence/strd_page.py"))
LONGLEY = "expression: {over: [x1, x2, x3, x4, x5, x6], start: {B0: 1, B1: 1, B2: 1, B3: 1, B4: 1, \
B5: 1, B6: 1}, model: B0 + B1*x1 + B2*x2 + B3*x3 + B4*x4 + B5*x5 + B6*x6}"
MISRA = "expression: {over: [x], start: {b1: 500, b2: 1e-4}, model: b1*(1 - exp(-b2*x))}"


def table(folder, nist):
    """Write a data set as a CSV file; return it and the options that name its regressors."""
    points = nist.points
    names = points.regressors or ("x",)
    path = folder / f"{nist.name}.csv"
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["y", *names])
        writer.writerows(np.column_stack([points.y, points.x]).tolist())
    return path, [word for name in names for word in ("--x", name)]


@pytest.mark.parametrize(
    ("name", "fit", "least"),
    [("Filip", "polynomial: {degree: 10}", 13), ("Longley", LONGLEY, 13), ("Misra1a", MISRA, 10.5)],
)
def test_fits_of_certified_data(name, fit, least, tmp_path):
    nist = strd["read"](name)
    path, regressors = table(tmp_path, nist)
    done = call("fit", path, "--y", "y", *regressors, "--fit", fit, "--json")
    assert done.code == 0, done.err
    coefficients = list(json.loads(done.out)["coefficients"].values())
    estimates = [coefficient["value"] for coefficient in coefficients]
    deviations = [coefficient["standard_uncertainty"] for coefficient in coefficients]
    assert strd["digits"](estimates, nist.estimates) >= least
    assert strd["digits"](deviations, nist.standard_deviations) >= min(least, 10.5)


def test_fit_is_shown_as_a_table(tmp_path):
    path = tmp_path / "points.csv"
    path.write_text("speed,torque,u\n" + "".join(f"{k},{1 + 2 * k},0.1\n" for k in range(9)))
    fit = "polynomial: {degree: 1, weighted: yes}"
    done = call("fit", path, "--y", "torque", "--x", "speed", "--u", "u", "--fit", fit)
    assert done.code == 0, done.err
    rows = [line.split()[:2] for line in done.out.splitlines() if line.startswith("c")]
    assert [name for name, _ in rows] == ["c0", "c1"]
    assert [float(value) for _, value in rows] == pytest.approx([1, 2])


XY = ("--y", "y", "--x", "x")


@pytest.mark.parametrize(
    ("text", "words", "code", "message"),
    [
        ("x,y\n1,2\n", ("--y", "y", "--x", "z"), 3, "t.csv:1: error: there is no column 'z'"),
        ("x,x\n1,2\n", ("--y", "x", "--x", "x"), 3, "there are several columns 'x'"),
        ("x,y\n1,2\n2,two\n", XY, 3, "t.csv:3: error: y: 'two' is not a number"),
        ("x,y\n1,2\n2\n", XY, 3, "t.csv:3: error: 1 cells; the first line has 2"),
        ("", XY, 3, "t.csv:1: error: the table is empty"),
        ("x,y\n1,2\n2,3\n", XY, 5, "needs 4 different values of x, got 2"),
        ("x,y\n1,2\nnan,3\n", XY, 3, "t.csv:3: error: x: 'nan' is not a number"),
        ("x,y\n1,2\n1_0,3\n", XY, 3, "t.csv:3: error: x: '1_0' is not a number"),
        ("x,y\n1,2\n", (*XY, "--fit", "polinomial"), 3, "polinomial"),
        ("x,y\n1,2\n", (*XY, "--fit", "polynomial: {degree: 11}"), 3, "degree"),
        ("x,y\n1,2\n", (*XY, "--fit", "polynomial: {"), 3, "--fit:2:1: error: not YAML"),
        ("x,y,z\n1,2,3\n", (*XY, "--x", "z"), 5, "of one regressor is given 2: x, z"),
        ("x,y\n1,2\n", ("--y", "y"), 2, "--x"),
    ],
)
def test_mistakes_are_reported_with_their_place(text, words, code, message, tmp_path):
    path = tmp_path / "t.csv"
    path.write_text(text)
    done = call("fit", path, *words)
    assert done.code == code, done.err
    assert message in done.err


def test_formula_has_the_names_of_the_columns(tmp_path):
    wear = tmp_path / "wear.csv"
    wear.write_text("load,wear\n1,2\n2,4.1\n3,5.9\n4,8.2\n", encoding="utf-8")
    called = call("fit", wear, "--y", "wear", "--x", "load")
    assert called.out.startswith("wear = c0 + c1·load + c2·load²\n")
