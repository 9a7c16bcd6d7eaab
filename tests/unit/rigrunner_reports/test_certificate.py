"""Certificate pages: languages, escaping, and a lab's own texts and templates."""

from __future__ import annotations

import json
import re
import sys
from dataclasses import replace
from datetime import date
from importlib.resources import files
from math import nan
from pathlib import Path
from types import SimpleNamespace
from typing import get_args

import pytest
import yaml

import rigrunner_panel
from helpers_certificate import NOW, ORDER, make_letterhead
from rigrunner.api.analysis import Check, Consequence
from rigrunner.api.certificate import (
    Authorisation,
    Certificate,
    DeviationKind,
    InstrumentEntry,
    LimitStatement,
    RejectedCycle,
    Restriction,
    certificate_json,
    parse_certificate,
)
from rigrunner.api.coordinates import CoordinateValue
from rigrunner.api.data import Estimate
from rigrunner.api.errors import DataError, InvalidFileError, MissingPackageError
from rigrunner.api.events import Alarm, Intervention, Note, StepEnded
from rigrunner.api.findings import MeasurementResult, ResultDefinition
from rigrunner.api.hooks import NoSettings
from rigrunner.api.letterhead import CertificateInput
from rigrunner.api.verdict import Verdict
from rigrunner.certificate.content import Issue, make_certificate, restrictions_of
from rigrunner.certificate.letterhead import read_letterhead
from rigrunner.certificate.order import complete
from rigrunner.certificate.results import named_of
from rigrunner.clock import utc_text
from rigrunner.documents.certifying.certify import read_source
from rigrunner.plots import draw
from rigrunner.registry import load_registry
from rigrunner_reports.certificate import render
from rigrunner_reports.certificate.pdf import pdf_maker
from rigrunner_reports.certificate.render import html
from rigrunner_reports.certificate.texts import names, said, shipped, shipped_languages, texts
from rigrunner_reports.certificate.wording import Wording
from unit.rigrunner_reports.helpers_html import read_html

pytestmark = pytest.mark.figures

EVIL = "'\"></td><script>alert(1)</script><img src=x onerror=alert(1)>{{ 7*7 }}"
AT = {"seq": 1, "monotonic_s": 0.0, "utc": "2026-03-01T12:00:00.000Z"}

ISSUED_RULES = ("simple", "guard_band_u", "guard_band_fraction", "non_binary")
"""Rules on issued certificates, whose pages are regenerated; other rules bring their own texts."""


OLD = Path(__file__).parents[2] / "data/0.1.0/certificates/SPECIMEN-DEMO-2026-0001.json"
"""A certificate of version 0.1.0, with the unit N·m in the names of its limit fields."""


def test_small_risk_is_not_printed_as_zero():
    wording = Wording(texts("de", {}))
    printed = [wording.percent(probability) for probability in (0.0, 3e-7, 0.025, 0.5, 1.0)]
    assert printed == ["< 0,01", "< 0,01", "2,5", "50", "100"]


def test_result_without_uncertainty_is_refused_with_its_coordinates():
    definition = ResultDefinition(name="one", unit="V")
    at = {"bench.current": CoordinateValue(1.0, "A")}
    result = MeasurementResult(
        of=definition, estimate=Estimate(1.0, nan, nan, "V"), coordinates=at, readings=1
    )
    with pytest.raises(DataError, match=r"^one at bench.current = 1 A has no uncertainty"):
        named_of(SimpleNamespace(other_results=(result,)))


@pytest.fixture(scope="module")
def source(quick):
    return read_source(quick.loaded, load_registry())


@pytest.fixture
def lab(tmp_path):
    return make_letterhead(tmp_path / "letterhead")


def certificate_of(source, letterhead, number="DEMO-2026-0007"):
    issue = Issue(
        number=number,
        issued_utc=utc_text(NOW),
        authorisation=Authorisation(by="A. Nother"),
        restrictions=tuple(restrictions_of(source, requested=False)),
        software={"Rigrunner": "0"},
    )
    order = complete(ORDER, {}, source.stored.header.inputs)
    return make_certificate(source, order, letterhead, issue)


def render_page(source, lab, language=""):
    letterhead = read_letterhead(lab, language)
    return html(CertificateInput(certificate_of(source, letterhead), letterhead))


def approved(source):
    """Return the same run as if it were of an approved procedure on a real rig."""

    def with_approval(run):
        approval = {"state": "approved", "by": "B. Oss", "utc": "2026-01-02T00:00:00Z"}
        header = replace(run.header, approval=approval)
        return replace(run, info=replace(run.info, header=header))

    def calibrated(data):
        calibration = {"calibration": None, "certificate": "C-7", "laboratory": "Cal Lab"}
        calibration |= {"calibrated": date(2026, 1, 2), "due": date(2099, 1, 2)}
        entries = data.instruments.items()
        instruments = {name: entry.model_copy(update=calibration) for name, entry in entries}
        return replace(data, instruments=instruments)

    no_load = with_approval(source.stored.partners["no_load"])
    stored = replace(with_approval(source.stored), partners={"no_load": no_load})
    result = source.result
    no_load_run = calibrated(result.run.partners["no_load"])
    run = replace(calibrated(result.run), partners={"no_load": no_load_run})
    return replace(source, stored=stored, result=replace(result, run=run), simulated=False)


@pytest.mark.parametrize("language", shipped_languages())
def test_every_language_has_every_text_with_same_placeholders(language):
    reference, translated = shipped("en"), shipped(language)
    assert set(translated) == set(reference)
    for key, text in translated.items():
        assert isinstance(text, str), key
        assert text.strip(), key
        assert names(text) == names(reference[key]), key


def test_german_texts_differ_from_english_texts():
    assert shipped_languages() == ["de", "en"]
    german, english = shipped("de"), shipped("en")
    same = {key for key in english if german[key] == english[key]}
    assert len(same) < 12, same


@pytest.mark.parametrize(
    ("recorded", "german"),
    [
        ("load-induced starting torque", "lastinduziertes Anlaufmoment"),
        (
            "Margin to the limit ≤ 0.95 N·m: 0.2283 N·m (U = 0.0101 N·m).",
            "Abstand zum Grenzwert ≤ 0.95 N·m: 0.2283 N·m (U = 0.0101 N·m).",
        ),
        (
            "001_1Hz scatters by 0.07 %; in the budget as 'steady speed'",
            "001_1Hz streut um 0.07 %; im Unsicherheitsbudget als „gleichmäßige Drehzahl“",
        ),
        ("a sentence of a plugin; no verdict", "a sentence of a plugin; keine Konformitätsaussage"),
        ("a sentence of a plugin", "a sentence of a plugin"),
    ],
)
def test_recorded_text_is_translated_where_known(recorded, german):
    assert said("de")(recorded) == german
    assert said("en")(recorded) == recorded


def stated(of, reason, **fields):
    required = ("named", "verdict", "limit", "source", "uncompensated")
    limits = {"lower": None, "upper": None, "probability_of_conformity": None}
    texts_of_it = dict.fromkeys(required, "?") | fields | {"of": of, "reason": reason}
    return LimitStatement(**texts_of_it, **limits)


@pytest.mark.parametrize(
    ("of", "reason", "german"),
    [
        ("mean", "Margin to the limit ≤ 0.95 N·m: 0.2 N·m.", "≤ 0,95 N·m: 0,2 N·m."),
        ("mean", "The mean: margin to the limit ≥ 1 V: 2 V.", "≥ 1 V: 2 V."),
        ("35 Hz", "At 35 Hz: margin to the limit ≥ 1 V: 2 V.", "≥ 1 V: 2 V."),
        ("35 Hz", "V, 35 Hz: Margin to the limit ≥ 1 V: 2 V.", "≥ 1 V: 2 V."),
        ("mean V", "Mean V: Margin to the limit ≥ 1 V: 2 V.", "≥ 1 V: 2 V."),
        ("V at a.i = 2 A", "V at a.i = 2 A: Margin to the limit ≥ 1 V: 2 V.", "≥ 1 V: 2 V."),
        (
            "worst V at a.i = 2 A",
            (
                "Worst V at a.i = 2 A: Margin to the limit 0.5 V to 2.5 V: 1 V, less than U = 2 V;"
                " conformity is not demonstrated."
            ),
            "0,5 V bis 2,5 V: 1 V, weniger als U = 2 V; die Konformität ist nicht nachgewiesen.",
        ),
    ],
)
def test_reason_of_a_verdict_is_translated_without_what_it_is_about(of, reason, german):
    wording = Wording(texts("de", {}))
    assert wording.reason(stated(of, reason, named="V")) == f"Abstand zum Grenzwert {german}"
    assert Wording(texts("en", {})).reason(stated(of, reason, named="V")) == reason


def test_reason_of_an_author_stays_as_written():
    wording = Wording(texts("de", {}))
    missing = "V at a.i = 0 A: There is no value of V at a.i = 0 A: the coil is cold at 1.5 K."
    german = "Es gibt keinen Wert von V bei a.i = 0 A: the coil is cold at 1,5 K."
    assert wording.reason(stated("V at a.i = 0 A", missing)) == german
    unknown = "V at a.i = 0 A: The coil is cold at 1.5 K."
    assert wording.reason(stated("V at a.i = 0 A", unknown)) == unknown


def test_panel_and_certificates_share_translations():
    table = Path(rigrunner_panel.__file__).parent / "static/texts/said.de.json"
    sections = json.loads(table.read_bytes()).values()
    # The panel has little room: its texts may contain soft hyphens.
    panel_texts = {
        english: german.replace("\N{SOFT HYPHEN}", "")
        for section in sections
        for english, german in section.items()
    }
    texts = files("rigrunner_reports") / "certificate/texts/de.yaml"
    certificate_texts = yaml.safe_load(texts.read_text(encoding="utf-8"))["said"]
    common = set(certificate_texts) & set(panel_texts)
    assert len(common) > 150
    assert {text for text in common if certificate_texts[text] != panel_texts[text]} == set()


def test_every_code_of_a_certificate_has_a_text():
    def options(model, field):
        return get_args(model.model_fields[field].annotation)

    needed = {f"deviation.{kind}" for kind in get_args(DeviationKind)}
    needed |= {f"specimen.{code}" for code in options(Restriction, "code")}
    needed |= {f"verdict.{verdict}" for verdict in Verdict}
    needed |= {f"rule.{rule}" for rule in ISSUED_RULES}
    needed |= {f"rejected.{what}" for what in options(RejectedCycle, "what")}
    states = set(options(InstrumentEntry, "calibration")) - {"calibrated"}
    needed |= {f"instruments.{state}" for state in states}
    assert needed <= set(shipped("en"))


@pytest.mark.parametrize(("language", "words"), [("en", "as agreed"), ("de", "wie vereinbart")])
def test_decision_rule_of_a_plugin_is_printed_with_its_own_text(source, lab, language, words):
    decision = replace(
        source.result.decision, rule="own: as agreed", rule_in={"de": "wie vereinbart"}
    )
    own_rule = replace(source, result=replace(source.result, decision=decision))
    assert words in read_html(render_page(own_rule, lab, language)).words
    letterhead = read_letterhead(lab, language)
    assert '"rule_words_in"' in certificate_json(certificate_of(own_rule, letterhead))
    assert '"rule_words_in"' not in certificate_json(certificate_of(source, letterhead))


def test_limits_have_units_and_old_certificates_are_read(source, lab):
    new = certificate_of(source, read_letterhead(lab, "en"))
    (statement,) = json.loads(certificate_json(new))["conformity"]["statements"]
    assert not [name for name in statement if name.endswith("_nm")]
    assert (statement["named"], statement["lower"], statement["upper"], statement["unit"]) == (
        *("torque", None, 0.95, "N·m"),
    )
    old = parse_certificate(OLD.read_bytes(), OLD.name)
    assert old.conformity.statements[0].upper == 0.95
    assert old.conformity.statements[0].guard_band == pytest.approx(0.01095, abs=1e-5)


def test_approved_procedure_on_real_rig_gives_no_specimen_certificate(source, lab):
    page = read_html(render_page(approved(source), lab))
    assert "Specimen" not in page.words
    assert "approved by B. Oss on 2026-01-02" in page.words
    assert "C-7 Cal Lab 2026-01-02, 2099-01-02" in page.words


@pytest.mark.parametrize("which", ["stored", "no_load"])
def test_draft_procedure_of_either_run_gives_a_specimen_certificate(source, which):
    source = approved(source)
    run = source.stored if which == "stored" else source.stored.partners["no_load"]
    edited = replace(run.header, approval={"state": "draft", "note": "changed after approval"})
    run = replace(run, info=replace(run.info, header=edited))
    stored = replace(run, partners=source.stored.partners) if which == "stored" else None
    source = replace(source, stored=stored or replace(source.stored, partners={"no_load": run}))
    (restriction,) = restrictions_of(source, requested=True)
    assert restriction.code == "draft_procedure"
    assert restriction.detail.endswith("changed after approval")


@pytest.mark.parametrize("requested", [True, False])
def test_trial_is_not_certified(source, requested):
    source = approved(source)
    trial = {
        name: entry.model_copy(update={"calibration": "trial"})
        for name, entry in source.result.run.instruments.items()
    }
    run = replace(source.result.run, instruments=trial)
    source = replace(source, result=replace(source.result, run=run))
    (restriction,) = restrictions_of(source, requested=requested)
    assert restriction.code == "trial"


@pytest.mark.parametrize("requested", [True, False])
def test_inconclusive_check_prevents_certification(source, requested):
    source = approved(source)
    inconclusive = Consequence.INCONCLUSIVE
    failed = Check("clipping", ok=False, text="it clips", consequence=inconclusive)
    checks = (*source.result.checks, failed)
    source = replace(source, result=replace(source.result, checks=checks))
    (restriction,) = restrictions_of(source, requested=requested)
    assert (restriction.code, restriction.detail) == ("inconclusive_check", "clipping")


def test_interventions_and_faults_are_listed(source, lab):
    events = (
        Intervention(**AT, action="override", by="O. Ver", reason="urgent", subject="overdue TQ-1"),
        Intervention(**AT, action="pause", by="P. Auser", reason="tea"),
        Alarm(**AT, source="guard", text="door opened"),
        Note(**AT, step="main[1]", text="squeaks"),
        StepEnded(**AT, step="main[2]", index=2, action="record", ok=False, recording="003_5Hz"),
    )
    former = (replace(source.stored.recordings[0], name="001_1Hz_try1"),)
    source = replace(source, stored=replace(source.stored, events=events, superseded=former))
    words = read_html(render_page(source, lab)).words
    for line in (
        "Override overdue TQ-1; by O. Ver; reason: urgent 2026-03-01 12:00:00 UTC",
        "Intervention pause ; by P. Auser; reason: tea",
        "Alarm guard : door opened",
        "Note main[1] : squeaks",
        "Step failed main[2] : 003_5Hz",
        "Repeated; the former recording is kept, and not used 001_1Hz_try1",
    ):
        assert line in words


def test_all_texts_are_escaped(source, lab):
    certificate = certificate_of(source, read_letterhead(lab))

    def spoiled(value, key=""):
        if key in {"files", "analysis"}:
            return value
        if isinstance(value, dict):
            return {name: spoiled(item, name) for name, item in value.items()}
        if isinstance(value, list):
            return [spoiled(item, key) for item in value]
        fixed = ("rigrunner", "code", "kind", "what", "motion", "language", "calibration")
        keep = key in fixed or "sha256" in key or not isinstance(value, str)
        ours = key.startswith("printed") or key == "unit" or key.endswith("utc")
        return value if keep or ours else EVIL

    content = spoiled(certificate.model_dump(mode="json"))
    bad = Certificate.model_validate_json(json.dumps(content))
    letterhead = replace(read_letterhead(lab), style="</style><script>alert(2)</script>")
    letterhead = replace(letterhead, texts={"en": {"title": EVIL.replace("{{ 7*7 }}", "")}})
    page = read_html(html(CertificateInput(bad, letterhead)))
    assert [script.get("type") for script in page.all("script")] == ["application/json"]
    assert all("onerror" not in image for image in page.all("img"))
    assert EVIL in page.words
    assert parse_certificate(certificate_json(bad), "x") == bad


def test_same_results_are_drawn_once_for_all_certificates(source, lab, monkeypatch):
    drawn = []
    monkeypatch.setattr(render, "draw", lambda picture: drawn.append(picture) or draw(picture))
    render._draw.cache_clear()
    letterhead = read_letterhead(lab)
    pages = [
        html(CertificateInput(certificate_of(source, letterhead, number), letterhead)).decode()
        for number in ("DEMO-2026-0000", "DEMO-2026-0000", "DEMO-2026-0007")
    ]
    assert len(drawn) == 1
    assert pages[0] == pages[1]
    figures = [re.findall(r'src="(data:image/svg[^"]*)"', page) for page in pages]
    assert figures[0] == figures[2]
    assert max(map(len, figures[2])) > 10_000  # the drawing, beside the logo


def test_texts_of_the_lab_override_shipped_texts(source, lab):
    (lab / "texts").mkdir()
    path = lab / "texts" / "en.yaml"
    path.write_text("rigrunner: texts/1\ntexts: {title: Report of test}\n")
    page = read_html(render_page(source, lab))
    assert "Report of test DEMO-2026-0007" in page.words
    assert "Statement of conformity" in page.words


@pytest.mark.parametrize(
    ("language", "texts", "message"),
    [
        ("en", "titel: x", r"texts\.titel: there is no such text \(did you mean 'title'"),
        ("en", "end: over", r"texts\.end: needed in this text: \{number\}"),
        ("en", "title: 'a { b'", r"texts\.title: "),
        (
            "fr",
            "title: Rapport",
            r"texts/fr\.yaml: texts: there is no text for 'decimal', 'number'",
        ),
    ],
)
def test_missing_or_wrong_text_is_an_error(source, lab, language, texts, message):
    (lab / "texts").mkdir()
    (lab / "texts" / f"{language}.yaml").write_text(f"rigrunner: texts/1\ntexts: {{{texts}}}\n")
    with pytest.raises(InvalidFileError, match=message):
        render_page(source, lab, language)


def test_lab_can_add_a_language(source, lab):
    (lab / "texts").mkdir()
    lines = [f"  {json.dumps(k)}: {json.dumps('x' + t)}" for k, t in shipped("en").items()]
    text = "\n".join(["rigrunner: texts/1", "texts:", *lines])
    (lab / "texts" / "eo.yaml").write_text(text)
    page = read_html(render_page(source, lab, "eo"))
    assert page.all("html")[0]["lang"] == "eo"
    assert "xStatement of conformity" in page.words


def test_templates_of_the_lab_override_shipped_templates(source, lab):
    (lab / "templates").mkdir()
    (lab / "templates" / "head.html.j2").write_text("<h1>Our own {{ c.number }}</h1>")
    assert "Our own DEMO-2026-0007" in read_html(render_page(source, lab)).words


@pytest.mark.parametrize(
    ("template", "message"),
    [
        ("<p>\n{{ c.nothing }}</p>", "nothing"),
        ("<p>\n{% if %}</p>", r"templates/head\.html\.j2:2: TemplateSyntaxError"),
        ("{{ ''.__class__.__mro__ }}", "SecurityError"),
        ("{{ t('no such key') }}", "KeyError"),
    ],
)
def test_broken_or_malicious_template_is_refused(source, lab, template, message):
    (lab / "templates").mkdir()
    (lab / "templates" / "head.html.j2").write_text(template)
    with pytest.raises(InvalidFileError, match=message):
        render_page(source, lab)


def test_missing_weasyprint_is_reported_with_install_hint(monkeypatch):
    monkeypatch.setitem(sys.modules, "weasyprint", None)
    with pytest.raises(MissingPackageError) as caught:
        pdf_maker(NoSettings())
    assert "rigrunner[pdf]" in caught.value.hint


def test_missing_pango_is_reported_without_output_on_stdout(monkeypatch, capsys):
    class Broken:
        def find_spec(self, name, *_):
            if name == "weasyprint":
                sys.stdout.write("-----\nWeasyPrint could not import some external libraries.")
                raise OSError("cannot load library 'pango-1.0-0'")

    monkeypatch.delitem(sys.modules, "weasyprint", raising=False)
    monkeypatch.setattr(sys, "meta_path", [Broken(), *sys.meta_path])
    with pytest.raises(MissingPackageError, match="does not find the library Pango"):
        pdf_maker(NoSettings())
    assert capsys.readouterr().out == ""


def test_specimen_claims_no_accreditation(source, lab):
    letterhead = read_letterhead(lab)
    accredited = letterhead.laboratory.model_copy(update={"accreditation": "D-PL-00000"})
    specimen = certificate_of(source, replace(letterhead, laboratory=accredited))
    assert specimen.restrictions
    real = specimen.model_copy(update={"restrictions": ()})
    claims = [
        "D-PL-00000" in read_html(html(CertificateInput(certificate, letterhead))).words
        for certificate in (real, specimen)
    ]
    assert claims == [True, False]
