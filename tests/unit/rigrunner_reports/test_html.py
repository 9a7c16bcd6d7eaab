# ruff: noqa: RUF001  (typographic signs are expected)
from __future__ import annotations

import re
from base64 import b64decode
from dataclasses import replace
from itertools import pairwise
from xml.etree import ElementTree as ET

import pytest

from helpers_figures import drawn
from rigrunner.api.analysis import Bias, Check, Consequence
from rigrunner.api.checks import skipped
from rigrunner.api.texts import refused_character
from rigrunner.api.verdict import Verdict
from rigrunner_reports.render import css_string, html
from unit.rigrunner_reports.helpers_html import read_html
from unit.rigrunner_reports.helpers_report import (
    TRUTH_NM,
    changed,
    deciding,
    loaded_result,
    no_load_result,
    report_input,
    torque_of,
)

DOI = "https://doi.org/10.3390/machines13110976"
PASSED = r"✓ pass\b"
HOSTILE = "</style></title><script>alert(1)</script>\"'&"


@pytest.fixture(scope="module")
def loaded_bytes():
    with drawn():
        return html(report_input())


@pytest.fixture(scope="module")
def loaded(loaded_bytes):
    return read_html(loaded_bytes)


@pytest.fixture(scope="module")
def no_load():
    with drawn():
        return read_html(html(report_input(no_load_result())))


def small(result):
    """Return the result with only its first two set-points and no fits: quick to draw."""
    return changed(
        result,
        loaded=torque_of(result).loaded[:2],
        no_load=torque_of(result).no_load[:2],
        fits=(),
        compensations={
            name: replace(method, points=method.points[:2])
            for name, method in torque_of(result).compensations.items()
        },
    )


@pytest.mark.thorough
@pytest.mark.usefixtures("drawn_figures")
def test_same_input_gives_the_same_bytes(loaded_bytes):
    assert html(report_input()) == loaded_bytes


def test_page_loads_no_resources_and_runs_no_scripts(loaded, no_load):
    for page in (loaded, no_load):
        tags = {tag for tag, _ in page.elements}
        assert not tags & {"script", "link", "iframe", "object", "form", "base"}
        sources = [image["src"] for image in page.all("img")]
        assert all(source.startswith("data:image/svg+xml;base64,") for source in sources)
        assert {link["href"] for link in page.all("a") if link["href"][0] != "#"} <= {DOI}
        assert not [a for _, attributes in page.elements for a in attributes if a.startswith("on")]


def test_style_sheet_loads_no_resources(loaded_bytes):
    style = re.search(rb"<style>(.*?)</style>", loaded_bytes, re.DOTALL)[1]
    assert b"url(" not in style
    assert b"@import" not in style


def test_every_picture_is_self_contained_svg(loaded):
    for image in loaded.all("img"):
        tree = ET.fromstring(b64decode(image["src"].split(",")[1]))  # noqa: S314  (our own)
        assert tree.tag.endswith("}svg")
        links = [v for e in tree.iter() for k, v in e.attrib.items() if k.endswith("href")]
        assert all(link.startswith("#") for link in links)


def test_every_picture_has_numbers_in_its_alt_text(loaded, no_load):
    for page in (loaded, no_load):
        assert all(re.search(r"[0-9]\.[0-9]|[0-9] of [0-9]", e["alt"]) for e in page.all("img"))


def test_page_has_landmarks_language_and_ordered_headings(loaded, no_load):
    for page in (loaded, no_load):
        tags = [tag for tag, _ in page.elements]
        assert page.all("html")[0]["lang"] == "en"
        assert [tags.count(tag) for tag in ("header", "nav", "main", "footer", "h1")] == [1] * 5
        levels = [int(tag[1]) for tag in tags if re.fullmatch("h[1-6]", tag)]
        assert all(b <= a + 1 for a, b in pairwise(levels))


def test_header_cells_have_scope_and_tables_have_captions(loaded):
    assert all(cell.get("scope") for cell in loaded.all("th"))
    assert len(loaded.all("caption")) == len(loaded.all("table"))


def test_contents_link_to_existing_sections(loaded, no_load):
    for page in (loaded, no_load):
        ids = [attributes["id"] for _, attributes in page.elements if "id" in attributes]
        assert len(ids) == len(set(ids))
        assert {e["href"][1:] for e in page.all("a") if e["href"][0] == "#"} <= set(ids)


def test_headline_is_rounded_to_its_uncertainty(loaded):
    assert "Td = 0.727 ± 0.012 N·m" in loaded.words
    assert re.search(PASSED, loaded.words)
    assert "Would it pass uncompensated? ✗ fail" in loaded.words


def test_simulated_truth_is_shown_with_the_error(loaded):
    assert f"Simulated rig: the truth {TRUTH_NM} N·m" in loaded.words
    assert "off by +1.2 mN·m, within its U" in loaded.words


def test_report_of_real_rig_does_not_mention_a_truth():
    page = read_html(html(report_input(small(loaded_result()), truth={})))
    assert "truth" not in page.words.lower()
    assert "simulated rig" not in page.words.lower()


def test_result_states_its_allowance_and_measurand(loaded):
    assert "beyond the stated allowance of 1.0 %" in loaded.words
    assert "not the breakaway torque from rest" in loaded.words


def test_published_method_is_cited_with_its_error(loaded):
    assert "Machines 2025, 13(11), 976" in loaded.words
    assert "its error is −163 mN·m at 1 Hz to +165 mN·m at 35 Hz" in loaded.words


def test_method_that_is_not_applicable_gives_the_reason(loaded):
    assert "tacho_only is not applicable to this run: there is no tacho channel" in loaded.words


def test_no_load_run_has_peaks_and_fits_but_no_verdict(no_load):
    assert "No-load torque of the rig".lower() in no_load.words.lower()
    assert "Verdict" not in no_load.words
    assert "not fitted: two points are not enough here" in no_load.words
    assert "no bearing is judged by it" in no_load.words


@pytest.mark.usefixtures("drawn_figures")
def test_texts_of_the_lab_are_escaped():
    base = small(loaded_result())
    run = replace(
        base.run,
        run_id=HOSTILE,
        procedure_title=HOSTILE,
        station_id=HOSTILE,
        inputs={"specimen": HOSTILE},
    )
    check = Check(HOSTILE, ok=False, text=HOSTILE, advice=HOSTILE)
    data = html(
        report_input(
            replace(base, run=run, symbol=HOSTILE, checks=(check,), notes=(HOSTILE,)),
            provenance={HOSTILE: HOSTILE},
            events=({"utc": HOSTILE, "kind": HOSTILE, "text": HOSTILE},),
        )
    )
    page = read_html(data)
    assert b"<script" not in data
    assert page.words.count(HOSTILE) >= 10


def test_hidden_characters_from_devices_are_made_visible():
    data = html(
        report_input(
            small(loaded_result()),
            provenance={"serial": "1\x1b[2J\N{RIGHT-TO-LEFT OVERRIDE}2"},
            events=({"utc": "", "kind": "note", "text": "a\x9bb"},),
        )
    ).decode()
    assert r"1\x1b[2J\u202e2" in data
    assert not refused_character(data)


def test_aborted_run_has_no_verdict():
    base = small(loaded_result())
    page = read_html(html(report_input(replace(base, run=replace(base.run, outcome="aborted")))))
    assert "This run ended as 'aborted'" in page.words
    assert "? no verdict" in page.words
    assert not re.search(PASSED, page.words)


def test_missing_result_is_reported_as_inconclusive():
    base = small(loaded_result())
    primary = replace(
        torque_of(base).compensations["template_inverse"],
        points=(),
        not_applicable="no low_pass",
    )
    decision = deciding(base.decision, verdict=Verdict.INCONCLUSIVE, probability=float("nan"))
    page = read_html(
        html(
            report_input(
                changed(
                    base,
                    headline=None,
                    notes=("template_inverse is not applicable: no low_pass",),
                    compensations={
                        **torque_of(base).compensations,
                        "template_inverse": primary,
                    },
                    decision=decision,
                )
            )
        )
    )
    assert "Td = no result" in page.words
    assert "? inconclusive" in page.words
    assert "Probability of conformity: not determined" in page.words


def test_skipped_checks_are_counted_separately_and_named():
    checks = (skipped("coupling", "no frequency is stated"), Check("zero", ok=True, text="agrees"))
    base = small(loaded_result())
    methods = {
        name: replace(method, checks=()) for name, method in torque_of(base).compensations.items()
    }
    page = read_html(html(report_input(changed(base, checks=checks, compensations=methods))))
    assert "The check passed; 1 not evaluated: coupling." in page.words
    assert "– not made coupling not checked: no frequency is stated" in page.words


def test_check_shows_its_effect_and_note_is_not_a_failure():
    biases = (Bias("mean", 0.012, 0.004), Bias("1 Hz", 0.001, 0.004), Bias("35 Hz", 0.031, 0.008))
    budget = Check("play", ok=False, text="it plays", biases=biases, consequence=Consequence.BUDGET)
    note = Check("cycles", ok=True, text="8 of them", consequence=Consequence.NOTE)
    base = small(loaded_result())
    methods = {
        name: replace(method, checks=()) for name, method in torque_of(base).compensations.items()
    }
    page = read_html(
        html(report_input(changed(base, checks=(note, budget), compensations=methods)))
    )
    assert "1 of 2 checks need attention: play" in page.words
    assert (
        "play it plays Effect: +0.0120 ± 0.0040 N·m on the mean, +0.0310 ± 0.0080 N·m at 35 Hz; "
        "in the budget as 'play'"
    ) in page.words
    assert "· note cycles 8 of them" in page.words


@pytest.mark.usefixtures("drawn_figures")
def test_run_of_one_point_without_fits_is_reported():
    base = small(loaded_result())
    result = changed(
        base,
        loaded=torque_of(base).loaded[:1],
        no_load=(),
        run=replace(base.run, partners={}),
        fits=(),
        compensations={
            name: replace(method, points=method.points[:1])
            for name, method in torque_of(base).compensations.items()
        },
    )
    page = read_html(html(report_input(result)))
    assert "One set-point, 1 Hz, under 1000 N" in page.words


def test_no_line_break_between_number_and_unit_or_sign(loaded_bytes):
    result = loaded_bytes.decode().split('<section id="result">')[1].split("</section>")[0]
    assert re.search(r"\d\u00a0N·m", result)
    assert re.findall(r"\d (?:N·m|mN·m|Hz|%|N)\b|(?:[=≤±]|&gt;) \d|\b[kUw] =", result) == []


def test_css_string_escapes_its_delimiters():
    assert (
        css_string('a"; } </style>\n')
        == r'"a\000022 \00003b  \00007d  \00003c \00002f style\00003e \00000a "'
    )


def contrast(foreground, background):
    """Return the contrast ratio of two #rrggbb colours (WCAG 2.2, relative luminance)."""
    light, dark = sorted((luminance(foreground), luminance(background)), reverse=True)
    return (light + 0.05) / (dark + 0.05)


def luminance(colour):
    parts = [int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)]
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in parts]
    return sum(w * c for w, c in zip((0.2126, 0.7152, 0.0722), linear, strict=True))


def test_text_colours_have_contrast_of_4_5_on_every_background(loaded_bytes):
    style = loaded_bytes.decode("utf-8").split("</style>")[0]
    colours = dict(re.findall(r"--([a-z]+): (#[0-9a-f]{6})", style))
    assert {"ink", "soft", "blue", "pass", "fail", "middle"} <= set(colours)
    grounds = ("#ffffff", colours["panel"], "#eaf3f9")
    for name in ("ink", "soft", "blue", "pass", "fail", "middle"):
        assert min(contrast(colours[name], ground) for ground in grounds) >= 4.5, name
