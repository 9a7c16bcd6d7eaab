"""A result by an equation on its certificate: the model as mathematics, its budget, verified."""

from __future__ import annotations

import json
import re
from math import sqrt

import pytest

from e2e.helpers_forgery import resealed, with_content
from helpers_any_quantity import STATION, written
from helpers_certificate import make_letterhead
from helpers_cli import call
from helpers_figures import drawn
from helpers_lacking import require_pdf
from rigrunner.proof.pdf import text_of

PROCEDURE = """\
rigrunner: procedure/2
id: PSU-POWER
revision: "A"
title: Power of a supply
inputs: {specimen: {ask: Serial number, unattended: PSU-1}}
uses: {bench: supply_bench}
main:
  - sweep:
      set: bench.current
      over: [1 A, 2 A]
      steps: [{measure: {channels: [bench.voltage]}}]
analysis:
  - equation:
      result: {name: power, symbol: P, text: power into the load, unit: W}
      per: bench.current
      inputs: {U: bench.voltage}
      constants: {R: {value: 10 Ω, limits: ±0.1 Ω}}
      model: P = U ** 2 / R
acceptance: {rule: simple, limits: [{of: power, each: bench.current, max: 15 W, source: sheet}]}
"""


@pytest.fixture(scope="module")
def issued(tmp_path_factory):
    folder = tmp_path_factory.mktemp("power")
    procedure, station = written(folder, procedure=PROCEDURE, station=STATION)
    words = ["--station", station, "--unattended", "--runs", folder / "runs"]
    called = call("run", procedure, *words)
    assert called.code == 0, called.err
    (run,) = (folder / "runs").iterdir()
    letterhead = make_letterhead(folder / "letterhead")
    with drawn():
        called = call(
            "certify", run, "--letterhead", letterhead, "--authorised-by", "A. Nother",
            "--customer", "C", "--customer-contact", "D", "--item", "I", "--item-id", "1",
            "--item-condition", "new", "--received", "2020-01-01", "--operator", "O",
            "--lang", "de", "--not-for-certification", "--out", folder / "out",
        )  # fmt: skip
    assert called.code == 0, called.err
    return run, letterhead, folder / "out"


def form(issued, suffix):
    (path,) = issued[2].glob(f"*{suffix}")
    return path


def verified(path, issued):
    words = ("--runs", issued[0].parent, "--letterhead", issued[1])
    with drawn():
        return call("verify", path, *words)


def test_content_has_equation_and_budget_of_the_deciding_value(issued):
    (model,) = json.loads(form(issued, ".json").read_text(encoding="utf-8"))["models"]
    (equation,) = model["equations"]
    assert (equation["symbol"], equation["text"]) == ("P", "U**2 / R")
    assert model["coordinates"]["bench.current"]["value"] == 1.0  # the greater power
    volts, ohms = 12.022, 10.0
    lines = {line["name"].split(",")[0].split(" ")[0]: line for line in model["budget"]}
    assert len(lines) == 2
    contributions = sorted(line["contribution"] for line in lines.values())
    # GUM 5.1.2 by hand: |2 U / R| 2 mV / sqrt(3), and (U / R)^2 0.1 Ω / sqrt(3)
    by_hand = 2 * volts / ohms * 0.002 / sqrt(3), (volts / ohms) ** 2 * 0.1 / sqrt(3)
    assert contributions == pytest.approx(by_hand, rel=1e-6)


def test_reason_is_in_the_language_of_the_certificate(issued):
    page = form(issued, ".html").read_text(encoding="utf-8")
    conformity = page.split('id="conformity"')[1].split("</section>")[0]
    # 12.022 V, squared, over 10 Ω is 14.45 W
    assert "Begründung: Abstand zum Grenzwert ≤ 15 W: 0,55 W." in conformity
    assert 'lang="en"' not in conformity


@pytest.mark.thorough
def test_every_form_shows_equation_and_budget_and_verifies(issued):
    require_pdf()
    page = form(issued, ".html").read_text(encoding="utf-8")
    section = page.split('<section id="models">')[1].split("</section>")[0]
    assert 'alttext="P = U**2 / R"' in section
    assert "<mfrac>" in section
    assert "Unsicherheitsbudget von P, bench.current = 1 A" in section
    shares = [
        float(share.replace(",", ".")) for share in re.findall(r"<td>(\d+,\d)</td></tr>", section)
    ]
    assert sum(shares) == pytest.approx(100, abs=0.1)
    text = text_of(form(issued, ".pdf").read_bytes())
    assert "Unsicherheitsbudget von P" in text
    for suffix in (".json", ".html", ".pdf"):
        called = verified(form(issued, suffix), issued)
        assert (called.code, called.out.splitlines()[0]) == (0, "MATCH"), called.out + called.err


@pytest.mark.parametrize("what", ["equation", "budget"])
def test_changed_model_does_not_verify(issued, tmp_path, what):
    path = tmp_path / form(issued, ".html").name
    path.write_bytes(form(issued, ".html").read_bytes())

    def change(content):
        (model,) = content["models"]
        if what == "equation":
            model["equations"][0]["text"] = "U ** 2 / (2 * R)"
        else:
            model["budget"][0]["contribution"] *= 0.5

    resealed(path, lambda page: with_content(page, change))
    called = verified(path, issued)
    assert called.code != 0
    assert "models" in called.out
