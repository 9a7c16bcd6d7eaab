"""A certificate of the demonstration: the requirements of ISO/IEC 17025:2017, 7.8, by item."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import pytest
from pypdf import PdfReader

from helpers_certificate import issue, make_letterhead, without_pdf
from helpers_cli import call
from helpers_lacking import require_pdf
from rigrunner.api.calibration import CalibratedRange
from rigrunner.api.certificate import certificate_json, parse_certificate
from rigrunner.api.errors import DataError, UsageError
from rigrunner.api.instruments import Instrument
from rigrunner.api.quantity import parse_quantity
from rigrunner.certificate.content import certifiable
from rigrunner.certificate.deviations import deviations_of
from rigrunner.certificate.order import Order
from rigrunner.certificate.surroundings import instruments_of
from rigrunner.certificate.validity import traceability_of
from rigrunner.documents.certifying.certify import _refuse_beyond_calibration, read_source
from rigrunner.registry import load_registry
from rigrunner_bearings.api.torque import TorqueDetails
from unit.rigrunner_reports.helpers_html import read_html

pytestmark = pytest.mark.figures

LANGUAGES = ("en", "de")


@pytest.fixture(scope="module")
def registry():
    return load_registry()


@pytest.fixture(scope="module")
def lab(tmp_path_factory):
    return make_letterhead(tmp_path_factory.mktemp("lab") / "letterhead")


@pytest.fixture(scope="module")
def issued(demo, quick, lab, registry, tmp_path_factory):
    """Return a specimen in each language, as (certificate, HTML page, path of the PDF).

    The German one is on a run of fewer set-points.
    """
    require_pdf()
    out = tmp_path_factory.mktemp("out")
    documents = {}
    for language, run in zip(LANGUAGES, (demo.loaded, quick.loaded), strict=True):
        result = issue(run, lab, out, registry=registry, language=language)
        files = {path.suffix: path for path in result.files}
        assert set(files) == {".json", ".html", ".pdf"}, result.notes
        page = read_html(files[".html"].read_bytes())
        documents[language] = (result.certificate, page, files)
    return documents


@pytest.fixture(scope="module")
def english(issued):
    return issued["en"]


# What 7.8.2.1, 7.8.2.2, 7.8.3.1, 7.8.6 and 7.8.7 ask for, and the words that answer it.
ISO_17025 = {
    "7.8.2.1 a, title": ("Test certificate",),
    "7.8.2.1 b, laboratory and address": (
        *("Demonstration laboratory (fictitious)", "1 Example Street, 00000 Sample Town"),
    ),
    "7.8.2.1 c, place of activity": ("Place of activity at the address above, test bench 1",),
    "7.8.2.1 d, identification and end": (
        *("Test certificate {number}", "End of certificate {number}"),
    ),
    "7.8.2.1 e, customer and contact": (
        *("Customer Muster & Söhne <Ltd>", "Address or contact 7 Customer Road, 11111 Elsewhere"),
    ),
    "7.8.2.1 f, method": (
        *("SSPB-STT-1000, revision A: Starting torque under 1000 N", "{method}"),
        *("not approved (draft)", "template_inverse"),
    ),
    "7.8.2.1 g, item, identification, condition": (
        *("Item tested Spherical plain bearing MS14101-9", "Identification DEMO-0001"),
        "Condition on receipt new, liner without visible damage",
    ),
    "7.8.2.1 h, date of receipt": ("Received 2025-11-03",),
    "7.8.2.1 i, dates of the test": ("Tested {started} UTC to {ended} UTC",),
    "7.8.2.1 j, date of issue": ("Issued 2026-11-22",),
    "7.8.2.1 k, sampling": ("The laboratory did no sampling",),
    "7.8.2.1 l, relates only to the items": ("The results relate only to the items tested.",),
    "7.8.2.1 m, results with units": ("Td = ({value} ± {u}) N·m", "Td, N·m U, N·m k"),
    "7.8.2.1 n, additions, deviations, exclusions": (
        *("Additions, deviations and exclusions", "Stated by the laboratory"),
        *("Outer ring clamped with two screws in place of four.", "Critical value"),
    ),
    "7.8.2.1 o, person authorising": ("Authorised by A. Nother, Head of laboratory",),
    "7.8.2.1 p, external results marked": (
        *("The following results were supplied by external providers.", "Hardness 60 HRC"),
        "Supplied by Other Laboratory",
    ),
    "7.8.2.1 note, reproduction in full": ("shall not be reproduced except in full",),
    "7.8.2.2 customer's information": ("were supplied by the customer",),
    "7.8.2.2 as received": ("the results apply to the item as received",),
    "7.8.3.1 a, conditions": ("Temperature tester.temperature 23.0", "Room not air-conditioned."),
    "7.8.3.1 a, load": (
        *("Load not measured by a calibrated instrument tester.load : no instrument for it",),
        *("its error is taken as ±0.5 %, by default", "names no instrument for the load"),
    ),
    "7.8.3.1 b, conditions of validity": (
        *("Conditions of validity", "at the reversals of a swing"),
        *("has without load is not contained", "friction of the supports does not grow with load"),
        *("(2.5 %)", "the friction is proportional to the load", "limits of another quantity"),
    ),
    "6.5 traceability": ("No metrological traceability of the results is claimed",),
    "7.8.3.1 c, uncertainty in the unit of the result": ("coverage factor k = {k}", "U, N·m"),
    "7.8.6.1 decision rule and risk": ("Guard band w = U", "Highest risk of a false pass 2.5 %"),
    "7.8.6.2 a, to which results": ("Applies to the mean over the set-points",),
    "7.8.6.2 b, specification": ("Specification demonstration only", "Limit ≤ 0.95 N·m"),
    "7.8.6.2 verdict as word and symbol": ("✓ pass",),
    "7.8.7 opinions marked": (
        *("are opinions and interpretations, not results", "The bearing runs in slowly."),
        "Opinion of O. Pinion",
    ),
    "6.5 instruments": (
        *("Rigrunner simulated torque transducer", "serial no. SIM-TQ-01", "tester.torque ±10 N·m"),
        *("simulated, not calibrated", "gain ±0.3 %", "zero ±0.02 N·m"),
    ),
    "7.5.1 operator": ("Operator Demo operator",),
    "proof": ("{digest}", "{file}"),
    "not a certificate": ("not for certification", "simulated, not measured"),
}


@pytest.mark.parametrize("item", ISO_17025)
def test_page_meets_each_item_of_the_standard(english, item):
    certificate, page, _ = english
    headline = certificate.results.headline
    values = {
        "number": certificate.number,
        "method": certificate.method.sha256,
        "started": certificate.performance.started_utc[:19].replace("T", " "),
        "ended": certificate.performance.ended_utc[:19].replace("T", " "),
        "value": headline.printed,
        "u": headline.printed_uncertainty,
        "k": headline.printed_factor,
        "digest": certificate.evidence.run.digest_sha256,
        "file": certificate.evidence.run.file_sha256,
    }
    words = [text.format(**values) for text in ISO_17025[item]]
    assert [text for text in words if text not in page.words] == []


IN_JSON = {
    "7.8.2.1 a, title": "rigrunner",
    "7.8.2.1 b, laboratory and address": "laboratory.address",
    "7.8.2.1 c, place of activity": "laboratory.place",
    "7.8.2.1 d, identification and end": "number",
    "7.8.2.1 e, customer and contact": "customer.contact",
    "7.8.2.1 f, method": "method.sha256",
    "7.8.2.1 g, item, identification, condition": "item.condition",
    "7.8.2.1 h, date of receipt": "item.received",
    "7.8.2.1 i, dates of the test": "performance.ended_utc",
    "7.8.2.1 j, date of issue": "issued_utc",
    "7.8.2.1 k, sampling": "item.sampling",
    "7.8.2.1 l, relates only to the items": None,
    "7.8.2.1 m, results with units": "results.headline.unit",
    "7.8.2.1 n, additions, deviations, exclusions": "deviations",
    "7.8.2.1 o, person authorising": "authorisation.by",
    "7.8.2.1 p, external results marked": "external",
    "7.8.2.1 note, reproduction in full": None,
    "7.8.2.2 customer's information": "customer.name",
    "7.8.2.2 as received": "item.sampling",
    "7.8.3.1 a, conditions": "conditions",
    "7.8.3.1 a, load": "results.points",
    "7.8.3.1 b, conditions of validity": "validity",
    "7.8.3.1 c, uncertainty in the unit of the result": "results.headline.expanded_uncertainty",
    "7.8.6.1 decision rule and risk": "conformity.rule",
    "7.8.6.2 a, to which results": "conformity.statements",
    "7.8.6.2 b, specification": "conformity.statements",
    "7.8.6.2 verdict as word and symbol": "conformity.verdict",
    "7.8.7 opinions marked": "opinions",
    "6.5 instruments": "instruments",
    "6.5 traceability": "traceability.claimed",
    "7.5.1 operator": "performance.operator",
    "proof": "evidence.run.digest_sha256",
    "not a certificate": "restrictions",
}
"""The member of each item in the JSON; None for a text that is on every page."""


def missing_member(content, item):
    """Return the member of an item that the JSON lacks, or ''."""
    value = content
    for name in (IN_JSON[item] or "").split("."):
        if name and name not in value:
            return IN_JSON[item]
        value = value[name] if name else value
    lacks = (IN_JSON[item] and value in (None, [], {})) or (
        value == "" and "sampling" not in (IN_JSON[item] or "")
    )
    return IN_JSON[item] if lacks else ""


def test_every_item_has_a_member_in_the_json():
    assert set(IN_JSON) == set(ISO_17025)


@pytest.mark.parametrize("item", ISO_17025)
def test_each_item_is_in_the_json_and_its_absence_is_detected(english, item):
    _, _, files = english
    content = json.loads(files[".json"].read_bytes())
    assert missing_member(content, item) == ""
    if IN_JSON[item] is None:
        return
    *way, last = IN_JSON[item].split(".")
    place = content
    for name in way:
        place = place[name]
    del place[last]
    assert missing_member(content, item) == IN_JSON[item]


@pytest.mark.parametrize("item", ISO_17025)
def test_documentation_lists_each_item_with_its_clause(item):
    page = Path(__file__).parents[2] / "docs/evidence/iso-17025.md"
    assert f"| {item} |" in page.read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("template", "words"),
    [
        ("result.html.j2", "Conditions of validity"),
        *(
            pytest.param(*case, marks=pytest.mark.thorough)
            for case in (
                ("surroundings.html.j2", "No metrological traceability"),
                ("deviations.html.j2", "Load not measured by a calibrated instrument"),
                ("points.html.j2", "names no instrument for the load"),
                ("statements.html.j2", "relate only to the items tested"),
                ("conformity.html.j2", "Guard band w = U"),
            )
        ),
    ],
)
def test_empty_template_removes_its_item(english, quick, tmp_path, template, words):
    """An empty template of the laboratory removes the words: the test can fail."""
    lab = make_letterhead(tmp_path / "letterhead")
    (lab / "templates").mkdir(exist_ok=True)
    (lab / "templates" / template).write_text("", encoding="utf-8")
    lacking = issue(quick.loaded, lab, tmp_path / "lacking", registry=without_pdf())
    page = next(path for path in lacking.files if path.suffix == ".html")
    assert words in english[1].words
    assert words not in read_html(page.read_bytes()).words


def test_conditions_of_validity_are_translated_to_german(issued):
    _, page, _ = issued["de"]
    for words in (
        "Voraussetzungen der Gültigkeit", "ohne Last hat, ist im Wert nicht enthalten",
        "Reibung der Stützlager mit der Last", "die Reibung der Last proportional ist",
        "Eine metrologische Rückführung der Ergebnisse wird nicht behauptet",
        "Last nicht mit einem kalibrierten Messmittel gemessen", "(2,5 %)",
    ):  # fmt: skip
        assert words in page.words, words


def test_conditions_of_validity_are_in_the_pdf(english):
    _, _, files = english
    text = " ".join(page.extract_text() for page in PdfReader(files[".pdf"]).pages)
    words = " ".join(text.split())
    assert "Conditions of validity" in words
    assert "No metrological traceability" in words


def test_every_set_point_has_its_result_and_uncertainty(demo, english):
    certificate, page, _ = english
    result = json.loads((demo.loaded / "result.json").read_text(encoding="utf-8"))
    points = result["compensations"]["template_inverse"]["points"]
    assert len(certificate.results.points) == len(points) == 12
    for point, expected in zip(certificate.results.points, points, strict=True):
        torque = expected["torque"]
        assert point.torque.value == pytest.approx(torque["value"], rel=1e-12)
        assert point.torque.expanded_uncertainty == pytest.approx(
            torque["expanded_uncertainty_95"], rel=1e-12
        )
        assert float(point.torque.printed) == round(torque["value"], point.torque.decimals)
        assert f"{point.torque.printed} {point.torque.printed_uncertainty}" in page.words


def test_json_stands_alone_and_inside_both_forms(english):
    certificate, _, files = english
    sealed = parse_certificate(files[".json"].read_bytes(), "x")
    assert sealed.seal
    assert sealed.model_copy(update={"seal": None}) == certificate
    text = certificate_json(certificate)
    page = files[".html"].read_text(encoding="utf-8")
    inside = re.search(r'<script type="application/json" id="certificate">\n(.*?)</script>', page,
                       re.DOTALL)[1]  # fmt: skip
    assert inside == text
    attached = PdfReader(files[".pdf"]).attachments[f"{certificate.number}.json"]
    assert attached == [text.encode()]


@pytest.mark.parametrize("language", LANGUAGES)
def test_every_page_has_certificate_and_page_number(issued, language):
    certificate, _, files = issued[language]
    pages = [page.extract_text() for page in PdfReader(files[".pdf"]).pages]
    assert 3 <= len(pages) <= 6
    word, of, end, mark = {
        "en": ("Page", "of", "End of certificate", "not for certification"),
        "de": ("Seite", "von", "Ende des Zertifikats", "nicht zur Zertifizierung"),
    }[language]
    for number, text in enumerate(pages, 1):
        assert f"{word} {number} {of} {len(pages)}" in text
        assert certificate.number in text
        assert mark in text
    assert f"{end} {certificate.number}" in pages[-1]
    assert all(end not in text for text in pages[:-1])


@pytest.mark.parametrize("language", LANGUAGES)
def test_pdf_is_tagged_with_title_language_and_bookmarks(issued, language):
    certificate, page, files = issued[language]
    reader = PdfReader(files[".pdf"])
    root = reader.trailer["/Root"]
    assert root["/MarkInfo"]["/Marked"]
    assert root["/Lang"] == language
    assert root["/ViewerPreferences"]["/DisplayDocTitle"]
    tags = set(structure_types(root["/StructTreeRoot"]))
    assert {"/H1", "/H2", "/Table", "/TR", "/TH", "/TD", "/Caption", "/Figure"} <= tags
    assert certificate.number in reader.metadata.title
    titles = [entry.title for entry in flat(reader.outline)]
    assert titles[0].endswith(certificate.number)
    assert len(titles) == 1 + len(page.all("h2"))


def structure_types(node):
    node = node.get_object()
    if isinstance(node, list):
        for child in node:
            yield from structure_types(child)
    elif isinstance(node, dict):
        if "/S" in node:
            yield node["/S"]
        if "/K" in node:
            yield from structure_types(node["/K"])


def flat(outline):
    for entry in outline:
        if isinstance(entry, list):
            yield from flat(entry)
        else:
            yield entry


@pytest.mark.parametrize("language", LANGUAGES)
def test_page_is_accessible_to_screen_readers(issued, language):
    certificate, page, _ = issued[language]
    assert page.all("html")[0]["lang"] == language
    assert all("scope" in cell for cell in page.all("th"))
    tables = page.all("table")
    unnamed = [table for table in tables if "aria-label" not in table]
    assert len(unnamed) == len(page.all("caption"))
    logo, figure = page.all("img")
    assert logo["alt"] == "Demonstration laboratory"
    comma = {"en": ".", "de": ","}[language]
    for point in certificate.results.points:
        shown = f"{point.torque.printed} ± {point.torque.printed_uncertainty}"
        assert shown.replace(".", comma) in figure["alt"]


def test_german_page_has_no_english_words(issued):
    _, page, _ = issued["de"]
    english = {"Result", "Method", "Instruments", "Limit", "Verdict", "Issued"}
    words = set(re.findall(r"[A-Za-z]+", page.words))
    assert not english & words
    assert "✓ bestanden" in page.words


@pytest.mark.thorough
def test_same_run_gives_the_same_bytes(quick, registry, tmp_path):
    first, second = (
        issue(
            quick.loaded,
            make_letterhead(tmp_path / name),
            tmp_path / "out" / name,
            registry=registry,
        )
        for name in ("a", "b")
    )
    for path, second_path in zip(first.files[:2], second.files[:2], strict=True):
        assert path.suffix in {".json", ".html"}
        assert path.read_bytes() == second_path.read_bytes()


@pytest.mark.thorough
def test_specimen_certificate_needs_its_option(quick, lab, tmp_path):
    with pytest.raises(UsageError, match=r"not approved and its data are simulated") as caught:
        issue(quick.loaded, lab, tmp_path, not_for_certification=False)
    assert "--not-for-certification" in caught.value.hint
    assert list(tmp_path.iterdir()) == []


@pytest.fixture(scope="module")
def source(quick, registry):
    return read_source(quick.loaded, registry)


def with_run(source, **changes):
    """Return a source whose run has other instruments or another rig."""
    run = replace(source.result.run, **changes)
    return replace(source, result=replace(source.result, run=run))


CELL = Instrument(
    channel="tester.load", measures="force", serial="LC-1", certificate="D-K-1", maker="M",
    accuracy="0.5 % reading", range={"max": "2 kN"},
)  # fmt: skip


def test_load_without_a_calibrated_instrument_is_not_certified(source):
    torque = source.result.run.instruments["tester.torque"]
    registered = {"tester.torque": torque}
    _refuse_beyond_calibration(with_run(source, instruments=registered | {"tester.load": CELL}))
    for cell, why in (
        (None, "no instrument for it is in the station's register; .* ±0.5 %, by default"),
        (CELL.model_copy(update={"certificate": ""}), "names no calibration certificate of LC-1"),
        (CELL.model_copy(update={"accuracy_": None}), "does not say how accurate LC-1 is"),
    ):
        entries = registered | ({} if cell is None else {"tester.load": cell})
        lacking = with_run(source, instruments=entries)
        with pytest.raises(UsageError, match=f"tester.load: .*{why}"):
            _refuse_beyond_calibration(lacking)
        (deviation,) = [deviation for deviation in _deviations(lacking) if deviation.kind == "load"]
        assert deviation.where == "tester.load"


def test_peaks_beyond_the_calibrated_range_are_not_certified(source):
    """Peaks at 109 % of the range are not certified; a specimen states them."""
    greatest = max(
        float(point.peak_nm[point.peak_kept].max())
        for point in TorqueDetails.of(source.result).loaded
    )
    torque = source.result.run.instruments["tester.torque"]
    for share, refused in ((1.09, True), (0.99, False)):
        limit, far = greatest / share, parse_quantity("-100 N·m")
        narrow = torque.model_copy(
            update={"range_": CalibratedRange(min=far, max=parse_quantity(f"{limit:.9f} N·m"))}
        )
        changed = with_run(source, instruments={"tester.torque": narrow, "tester.load": CELL})
        beyond = [deviation for deviation in _deviations(changed) if deviation.kind == "range"]
        assert bool(beyond) == refused
        if not refused:
            _refuse_beyond_calibration(changed)
            continue
        assert "(109 %)" in beyond[0].text
        with pytest.raises(UsageError, match=r"tester.torque exceeded .*\(109 %\)"):
            _refuse_beyond_calibration(changed)


def test_traceability_is_claimed_if_torque_and_load_are_calibrated(source):
    torque = source.result.run.instruments["tester.torque"]
    paper = torque.model_copy(update={"certificate": "D-K-2", "calibration": None})
    entries = {"tester.torque": paper, "tester.load": CELL}
    run = replace(source.result.run, instruments=entries, partners={})
    result = replace(source.result, run=run)
    traceability = traceability_of(result, tuple(instruments_of(run)))
    assert (traceability.claimed, traceability.certificates) == (True, ("D-K-2", "D-K-1"))
    alone = replace(run, instruments={"tester.torque": paper})
    result = replace(result, run=alone)
    assert not traceability_of(result, tuple(instruments_of(alone))).claimed


def test_unmeasured_ambient_conditions_are_a_deviation(source):
    deviations = deviations_of(source.stored, source.result, Order(), (), ())
    assert [deviation.kind for deviation in deviations].count("conditions") == 1
    stated = deviations_of(source.stored, source.result, Order(conditions="23 °C"), (), ())
    assert "conditions" not in [deviation.kind for deviation in stated]


def _deviations(source):
    instruments = tuple(instruments_of(source.result.run))
    return list(deviations_of(source.stored, source.result, Order(), instruments, ()))


@pytest.mark.parametrize("outcome", ["aborted", "error"])
def test_incomplete_run_is_not_certified(source, outcome):
    info = replace(source.stored.info, outcome=outcome, reason="guard opened")
    interrupted = replace(source, stored=replace(source.stored, info=info))
    with pytest.raises(DataError, match=f"ended as '{outcome}': guard opened"):
        certifiable(interrupted)


def test_run_without_a_result_is_not_certified(quick, lab, tmp_path, registry):
    with pytest.raises(DataError, match="has no result to certify"):
        issue(quick.no_load, lab, tmp_path, registry=registry)


@pytest.mark.thorough
def test_further_copy_needs_a_reason(quick, tmp_path):
    require_pdf()
    lab = make_letterhead(tmp_path / "letterhead")
    order = ("--customer", "Muster", "--customer-contact", "x", "--item", "bearing")
    order += ("--item-condition", "new", "--received", "2026-02-27", "--not-for-certification")
    where = ("--letterhead", lab, "--out", tmp_path / "out", "--authorised-by", "A")
    first = call("certify", quick.loaded, *order, *where)
    assert first.code == 0, first.err
    assert "making the pages: 1 of" in first.err
    assert "SPECIMEN-DEMO-2026-0001 is issued: 3 files" in first.err
    for more in ((), ("--lang", "de"), ("--customer", "Another")):
        refused = call("certify", quick.loaded, *order, *where, *more)
        assert refused.code == 2
        assert "SPECIMEN-DEMO-2026-0001 exists" in refused.err
        assert "amend it" in refused.err
        assert "--further-copy REASON" in refused.err
    reason = ("--further-copy", "asked for in German", "--lang", "de")
    further = call("certify", quick.loaded, *order, *where, *reason)
    assert further.code == 0, further.err
    content = json.loads((tmp_path / "out/SPECIMEN-DEMO-2026-0002.json").read_bytes())
    assert content["further_copy"] == {
        "number": "SPECIMEN-DEMO-2026-0001", "reason": "asked for in German", "by": "A",
    }  # fmt: skip
    page = read_html((tmp_path / "out/SPECIMEN-DEMO-2026-0002.html").read_bytes())
    assert "Weiteres Exemplar neben SPECIMEN-DEMO-2026-0001" in page.words
    assert "asked for in German" in page.words


@pytest.mark.thorough
def test_command_issues_and_amends_once(quick, tmp_path):
    lab = make_letterhead(tmp_path / "letterhead")
    order = ("--customer", "Mustre", "--customer-contact", "x", "--item", "bearing")
    order += ("--item-condition", "new", "--received", "2026-02-27")
    where = ("--letterhead", lab, "--out", tmp_path / "out")
    called = call(
        "certify", quick.loaded, "--authorised-by", "A", *order, *where, "--not-for-certification"
    )
    assert called.code == 0, called.err
    first = called.out.splitlines()[0]
    before = {path: path.read_bytes() for path in (tmp_path / "out").iterdir()}
    amend = ("amend", first, "--reason", "misspelt", "--by", "B", *where, "--customer", "Muster")
    late = call(*amend, "--received", "2030-01-01")
    assert late.code == 2
    assert "--received 2030-01-01 is after the test, which began on 20" in late.err
    called = call(*amend)
    assert called.code == 0, called.err
    assert {path: path.read_bytes() for path in before} == before
    second = json.loads((tmp_path / "out" / "SPECIMEN-DEMO-2026-0002.json").read_text("utf-8"))
    original = json.loads((tmp_path / "out" / "SPECIMEN-DEMO-2026-0001.json").read_text("utf-8"))
    assert second["amends"]["number"] == original["number"]
    assert second["amends"]["changes"] == [
        {"field": "customer.name", "before": "Mustre", "after": "Muster"}
    ]
    assert second["results"] == original["results"]
    page = read_html((tmp_path / "out" / "SPECIMEN-DEMO-2026-0002.html").read_bytes())
    for words in (original["number"], "misspelt", "Mustre", "customer.name", "replaces"):
        assert words in page.words
    refused = call(*amend)
    assert refused.code == 2
    assert "was already replaced by SPECIMEN-DEMO-2026-0002" in refused.err
    with open(first, "a", encoding="utf-8") as file:  # noqa: PTH123  (a printed path)
        file.write(" ")
    assert "has changed since it was issued" in call(*amend).err


def test_command_withdraws_for_good(quick, tmp_path):
    lab, out = make_letterhead(tmp_path / "letterhead"), tmp_path / "out"
    number = issue(quick.loaded, lab, out, registry=without_pdf()).certificate.number
    first = out / f"{number}.json"
    where = ("--letterhead", lab)
    run = ("--runs", quick.loaded.parent)

    words = ("withdraw", first, "--by", "Z. Head", "--reason")
    assert call(*words, " ", *where).code == 2
    done = call(*words, "the wrong item was tested", *where)
    assert (done.code, done.out.strip()) == (0, str(out / f"{number}.withdrawn.json")), done.err
    assert "inform everyone who has it" in done.err
    again = call(*words, "again", *where)
    assert again.code == 2
    assert f"{number} was already withdrawn by Z. Head on 20" in again.err

    who = "withdrawn by Z. Head on "
    for lead, options in (("", where), (f", as {number}.withdrawn.json beside it says", ())):
        verified = call("verify", first, *run, *options)
        assert verified.code == 14
        text = f"WITHDRAWN: {number} is no longer in force{lead}: {who}"
        assert verified.out.startswith(text), verified.out
        assert ": the wrong item was tested" in verified.out.splitlines()[0]
        assert "DIFFERS" not in verified.out

    order = ("--customer", "C", "--customer-contact", "x", "--item", "bearing", "--authorised-by",
             "A", "--item-condition", "new", "--received", "2025-11-03",
             "--not-for-certification")  # fmt: skip
    refused = call("certify", quick.loaded, *order, *where, "--out", out)
    assert refused.code == 2
    assert f"{number} was issued on {quick.loaded.name}, and {who}" in refused.err
    assert f"'rigrunner amend' replaces {number}" in refused.err


@pytest.mark.thorough
def test_withdrawn_certificate_is_replaced_by_one_that_says_so(quick, tmp_path):
    lab, out = make_letterhead(tmp_path / "letterhead"), tmp_path / "out"
    number = issue(quick.loaded, lab, out, registry=without_pdf()).certificate.number
    first, where = out / f"{number}.json", ("--letterhead", lab)
    run = ("--runs", quick.loaded.parent)
    words = ("--by", "Z. Head", "--reason", "the wrong item")
    assert call("withdraw", first, *words, *where).code == 0
    replaced = call("amend", first, "--by", "B", "--reason", "found", "--item-id", "42", *where)
    assert replaced.code == 0, replaced.err
    second = Path(replaced.out.split()[0])
    assert second.stem == "SPECIMEN-DEMO-2026-0002"
    page = read_html(second.with_suffix(".html").read_bytes())
    assert "withdrawn by Z. Head on 20" in page.words
    assert call("verify", second, *run, *where).code == 0
    both = call("verify", first, *run, *where)
    assert (both.code, f"; REPLACED: {number}" in both.out) == (14, True)
