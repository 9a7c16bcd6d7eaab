"""JCGM 100:2008 (the GUM), H.1 to H.3, as procedures without any Python code for the analysis.

The procedures are in `gum/`; the figures are those that the guide prints.
"""

from __future__ import annotations

import json
from math import floor, inf, sqrt
from pathlib import Path

import pytest

from helpers_certificate import make_letterhead
from helpers_cli import call
from rigrunner.signal.uncertainty import coverage_factor

HERE = Path(__file__).parent / "gum"


@pytest.fixture(scope="module")
def run_example(tmp_path_factory):
    """Return, by example, the run's folder and the document of its result."""

    def run(name):
        if name not in finished:
            runs = tmp_path_factory.mktemp(name)
            output = call("run", HERE / f"{name}.yaml", "--station", HERE / f"{name}_station.yaml",
                          "--unattended", "--runs", runs)  # fmt: skip
            assert output.code == 0, output.err
            (folder,) = runs.iterdir()
            finished[name] = folder, json.loads((folder / "result.json").read_text("utf-8"))
        return finished[name]

    finished = {}
    return run


def estimates(document):
    return {result["name"]: result["estimate"] for result in document["results"]}


def table(document, title):
    return next(entry["rows"] for entry in document["tables"] if entry["title"].startswith(title))


def as_printed(value, digits):
    return float(f"{value:.{digits}f}")


def test_h_1_length_and_its_uncertainty(run_example):
    """H.1.6: 50.000 838 mm, u_c = 32 nm, 16 degrees of freedom, U_99 = 2.92 x 32 nm = 93 nm."""
    length = estimates(run_example("h1")[1])["length"]
    assert as_printed(length["value"], 6) == 50.000838
    u = length["standard_uncertainty"] * 1e6
    assert round(u) == 32
    assert floor(length["degrees_of_freedom"]) == 16
    k = coverage_factor(floor(length["degrees_of_freedom"]), 0.99)
    assert as_printed(k, 2) == 2.92
    assert round(k * round(u)) == 93


def test_h_1_table_h_1(run_example):
    """Each |c_i| u(x_i) in nm, and the degrees of freedom of d, as in the table."""
    budget = {line["name"]: line for line in run_example("h1")[1]["results"][0]["budget"]}
    u = {name: line["contribution"]["value"] * 1e6 for name, line in budget.items()}
    assert round(u["l_S"]) == 25
    assert [as_printed(u[name], 1) for name in ("d", "d_1", "d_2")] == [5.8, 3.9, 6.7]
    of_d = sqrt(u["d"] ** 2 + u["d_1"] ** 2 + u["d_2"] ** 2)
    assert as_printed(of_d, 1) == 9.7
    dof = of_d**4 / (u["d"] ** 4 / 24 + u["d_1"] ** 4 / 5 + u["d_2"] ** 4 / 8)
    assert as_printed(dof, 1) == 25.6
    assert u["alpha_S"] == u["theta_mean"] == u["Delta"] == 0
    assert as_printed(u["delta_alpha"], 1) == 2.9
    assert as_printed(u["delta_theta"], 1) == 16.6
    variation = [budget[name]["standard_uncertainty"]["value"] for name in ("theta_mean", "Delta")]
    assert as_printed(sqrt(sum(value**2 for value in variation)), 2) == 0.41
    freedom = [budget[name]["degrees_of_freedom"] for name in ("l_S", "delta_alpha", "delta_theta")]
    assert freedom == [18, 50, 2]


def test_h_1_terms_of_second_order(run_example):
    """H.1.7: 11.7 nm and 1.7 nm; they increase u_c from 32 nm to 34 nm."""
    document = run_example("h1")[1]
    assert round(estimates(document)["length_second_order"]["standard_uncertainty"] * 1e6) == 34
    (curved,) = [line for line in document["results"][1]["budget"] if "second" in line["name"]]
    assert curved["contribution"]["value"] * 1e6 == pytest.approx(sqrt(11.7**2 + 1.7**2), abs=0.05)
    assert any("the curvature of the model counts" in note for note in document["notes"])


def test_h_2_inputs(run_example):
    """Table H.2: means, their standard uncertainties, and their correlation."""
    rows = {name: row for name, *row in table(run_example("h2")[1], "Inputs")}
    assert [as_printed(rows["V"][0], 4), as_printed(rows["V"][1], 4)] == [4.9990, 0.0032]
    assert [as_printed(rows["I"][0] * 1e3, 4), as_printed(rows["I"][1] * 1e3, 4)] == [
        19.6610,
        0.0095,
    ]
    assert [as_printed(rows["phi"][0], 5), as_printed(rows["phi"][1], 5)] == [1.04446, 0.00075]
    r = [
        coefficient for *_, coefficient in table(run_example("h2")[1], "Correlation of the inputs")
    ]
    assert [as_printed(coefficient, 2) for coefficient in r] == [-0.36, 0.86, -0.65]


def test_h_2_results(run_example):
    """Table H.3. For X the guide prints u = 0.295, which is 0.2956 before rounding."""
    results = estimates(run_example("h2")[1])
    rounded = {name: (as_printed(result["value"], 3), result["standard_uncertainty"])
             for name, result in results.items()}  # fmt: skip
    assert rounded["resistance"] == (127.732, pytest.approx(0.071, abs=5e-4))
    assert rounded["reactance"] == (219.847, pytest.approx(0.295, abs=1e-3))
    assert rounded["impedance"] == (254.260, pytest.approx(0.236, abs=5e-4))
    assert [result["degrees_of_freedom"] for result in results.values()] == [4, 4, 4]


def test_h_2_correlation_of_results(run_example):
    rows = table(run_example("h2")[1], "Correlation of the results")
    assert [as_printed(row[-1], 3) for row in rows] == [-0.588, -0.485, 0.993]


def test_h_3_line(run_example):
    """H.3.3: y1 = -0.1712, u 0.0029; y2 = 0.002 18, u 0.000 67; r = -0.930; nu = 9."""
    document = run_example("h3")[1]
    results = estimates(document)
    assert results["intercept"]["value"] == pytest.approx(-0.1712037901313500, rel=1e-12)
    assert results["intercept"]["standard_uncertainty"] == pytest.approx(
        0.0028775978351600, rel=1e-9
    )
    assert results["slope"]["value"] == pytest.approx(0.0021826977398873, rel=1e-11)
    assert results["slope"]["standard_uncertainty"] == pytest.approx(0.0006679387732278, rel=1e-9)
    assert results["intercept"]["degrees_of_freedom"] == pytest.approx(9, rel=1e-6)
    assert "Correlation of intercept and slope: -0.930430." in document["notes"]


def test_h_3_correction_at_30_degrees(run_example):
    """H.3.4: -0.1494 °C, u 0.0041 °C, nu = 9; by the curve and by the printed line."""
    results = estimates(run_example("h3")[1])
    assert results["predicted"]["value"] == pytest.approx(-0.1493768127, abs=5e-11)
    assert results["predicted"]["standard_uncertainty"] == pytest.approx(0.0041385958, abs=5e-11)
    for name in ("predicted", "correction"):
        assert as_printed(results[name]["value"], 4) == -0.1494
        assert as_printed(results[name]["standard_uncertainty"], 4) == 0.0041
        assert results[name]["degrees_of_freedom"] == pytest.approx(9, rel=1e-6)


def test_gum_and_monte_carlo_are_side_by_side(run_example):
    """The trials of H.2 give the same interval; their u is that of t, wider by sqrt(4/2)."""
    (row,) = table(run_example("h2")[1], "GUM and Monte Carlo, in Ω")
    assert row[-1] == "yes"
    assert row[6] / row[2] == pytest.approx(sqrt(2), rel=0.02)
    assert inf > row[4] > row[1]


def test_report_shows_equation_and_budget(run_example):
    page = (
        (run_example("h1")[0] / "report.html")
        .read_text(encoding="utf-8")
        .replace("\N{NO-BREAK SPACE}", " ")
    )
    assert '<math display="block" alttext="l = l_S + d + d_1 + d_2 - l_S * (' in page
    assert "<msub><mi>δ</mi><mtext>α</mtext></msub>" in page  # noqa: RUF001
    assert "curvature of the model (second order)" in page
    assert "GUM and Monte Carlo, in mm" in page


@pytest.mark.thorough
def test_result_of_equation_is_certified_and_verified(run_example, tmp_path):
    folder, document = run_example("h1")
    assert document["verdict"]["verdict"] == "pass"
    letterhead = make_letterhead(tmp_path / "letterhead")
    issued = call("certify", folder, "--letterhead", letterhead, "--authorised-by", "A. Nother",
                  "--not-for-certification", "--customer", "Example Ltd", "--customer-contact",
                  "1 Road", "--item", "End gauge", "--item-id", "GAUGE-1", "--item-condition",
                  "new", "--received", "2020-01-01", "--operator", "O. Perator", "--out",
                  tmp_path / "documents")  # fmt: skip
    assert issued.code == 0, issued.err
    (certificate,) = (tmp_path / "documents").glob("*.json")
    assert "50.000838" in certificate.read_text(encoding="utf-8")
    verified = call("verify", certificate, "--letterhead", letterhead, "--runs", folder.parent)
    assert verified.code == 0, verified.out
    archive = tmp_path / "archive.sqlite"
    indexed = call("archive", "index", folder.parent, "--database", archive)
    assert indexed.code == 0, indexed.err
