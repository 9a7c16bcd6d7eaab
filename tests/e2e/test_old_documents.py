"""Documents of version 0.1.0 stay readable, and verify as stated in their README."""

from __future__ import annotations

import json
from dataclasses import replace
from math import hypot
from pathlib import Path

import pytest

from e2e.helpers_forgery import resealed
from helpers_cli import call
from rigrunner.analysis.revisions import OWN
from rigrunner.certificate.content import REVISION
from rigrunner.documents.packing.unpack import unpack
from rigrunner.documents.verifying.certificate import Means, verify_certificate
from rigrunner.proof.contents import content_in
from rigrunner.registry import Registry, load_registry
from rigrunner.runfile import read

pytestmark = pytest.mark.thorough

OLD = Path(__file__).parents[1] / "data" / "0.1.0"
RUN = "20260301T120000Z_SSPB-STT-1000_DEMO-0001"
MEAN_NM, MEAN_U_NM = 0.729, 0.011
"""As printed on the certificate, read with a text editor when it was added."""


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """Unpack the run of version 0.1.0."""
    folder = tmp_path_factory.mktemp("old") / "runs"
    unpack(OLD / "run.zip", folder)
    return folder


def test_pack_and_its_run_are_read(runs):
    stored = read(runs / RUN)
    assert [recording.name for recording in stored.recordings] == [
        *("001_8Hz", "002_15Hz", "003_25Hz", "004_35Hz"),
    ]
    assert stored.partners["no_load"].digest == read(OLD / "no_load" / "run.h5").digest


DIGESTS = {
    OLD.parent / "format-1" / "run.h5": (
        *("3ffd9e8e7390cafc2770c192fe948c557e9e5e62830db3bb8ba5d26b9f6b09bf", 1),
    ),
    OLD / "no_load" / "run.h5": (
        *("320a125f1e6b0a0bfedf0f888063dfbbf96defc75c3464d342ac3aff18bd1d27", 2),
    ),
    OLD / "table" / "run.h5": (
        *("fe4e7e3bf4c527ff2d4ce15c8dd8fd6bd8c6e78edab6fc742f4bfd7a226b0987", 2),
    ),
}
"""As version 0.1.0 computed them, and the format of the file."""


@pytest.mark.parametrize("path", DIGESTS, ids=lambda path: path.parent.name)
def test_digest_of_a_run_follows_its_format(path):
    stored = read(path)
    assert (stored.digest, stored.info.format) == DIGESTS[path]


def test_old_rows_are_read_and_verified():
    rows = read(OLD / "table" / "run.h5").measurements
    assert [row.name for row in rows] == ["rest", "loads", "loads", "loads", "after"]
    assert rows[-1].values["tester.load"] == pytest.approx(500.0737, abs=1e-3)
    done = call("verify", OLD / "table" / "run.h5")
    assert (done.code, done.out.splitlines()[0]) == (0, "MATCH"), done.out


def test_analysis_of_a_run_gives_the_numbers_of_its_certificate(runs):
    done = call("analyse", runs / RUN, "--json")
    compensated = json.loads(done.out)["headline"]["compensated"]
    # changes of methods, and what is now assumed of the support: 1.25 % of its friction
    moved_nm = 5e-4 if revisions()[1] == {1} else 0.5 * MEAN_U_NM
    assert compensated["value"] == pytest.approx(MEAN_NM, abs=moved_nm)
    # its station does not state its support: triangular, ±8 % of what builds up of 0.76 N·m
    drift_nm = 1.9 * 0.08 / 6**0.5 * 0.82 * 0.76
    assert compensated["expanded_uncertainty_95"] == pytest.approx(
        hypot(MEAN_U_NM, drift_nm), rel=0.15
    )


AMENDMENT = OLD / "certificates" / "SPECIMEN-DEMO-2026-0002.json"
ORIGINAL = AMENDMENT.with_name("SPECIMEN-DEMO-2026-0001.json")
LETTERHEAD = ("--letterhead", OLD / "letterhead")


def revisions():
    """Return the installed revisions of all that made the documents of version 0.1.0."""
    registry = load_registry()
    content = json.loads(AMENDMENT.read_text("utf-8"))
    settings = content["method"]["analysis"]
    methods = [
        ("outlier_rule", settings["outliers"]["name"]),
        *(("fit", fit["name"]) for fit in settings["fits"]),
        *(("compensation", compensation["name"]) for compensation in settings["compensations"]),
    ]
    layouts = {registry.revision("certificate_format", name) for name in ("html", "pdf")}
    return layouts, {*OWN.values(), *(registry.revision(*method) for method in methods)}


def test_old_certificate_never_differs(runs):
    """Where a layout or a method has another revision now, `verify` says so instead."""
    done = call("verify", AMENDMENT, "--runs", runs, *LETTERHEAD)
    layouts, methods = revisions()
    code = 12 if layouts != {1} else 13 if methods | {REVISION} != {1} else 0
    assert (done.code, "DIFFERS" in done.out) == (code, False), done.out


def test_old_run_never_differs(runs):
    done = call("verify", runs / RUN)
    code = 0 if revisions()[1] == {1} else 13
    assert (done.code, "DIFFERS" in done.out) == (code, False), done.out


def test_old_signature_proves_its_pages(runs):
    """The original was replaced since, as the first line says."""
    words = ("--runs", runs, "--trust", OLD / "lab.key.pub")
    done = call("verify", ORIGINAL, *words, *LETTERHEAD)
    assert done.code == 11, done.out
    assert done.out.startswith(
        f"REPLACED: {ORIGINAL.stem} is no longer in force: {AMENDMENT.stem} replaced it"
    )
    assert "PAGE NOT PROVEN" not in done.out
    assert "DIFFERS" not in done.out


@pytest.mark.parametrize("suffix", [".json", ".html", ".pdf"])
def test_content_of_every_old_form_is_read(suffix):
    path = AMENDMENT.with_suffix(suffix)
    content = content_in(path.read_bytes(), suffix, path.name)
    assert content.results.headline.value == pytest.approx(MEAN_NM, abs=5e-4)
    assert (content.evidence.revisions, content.appearance.layouts) == ({}, {})


def with_other_revision(kind):
    """Return the installed plugins with another revision for all of one kind."""
    plugins = load_registry().plugins
    return Registry(
        replace(plugin, record=replace(plugin.record, revision=99))
        if plugin.kind == kind
        else plugin
        for plugin in plugins
    )


def test_pages_of_a_newer_layout_are_unproven_but_searched_for_results(runs, tmp_path):
    registry = with_other_revision("certificate_format")
    means = Means(run=runs / RUN, runs=runs, registry=registry, letterhead=OLD / "letterhead")
    checked = verify_certificate(AMENDMENT, means)
    assert checked.differences == []
    assert checked.unproven == [
        f"{AMENDMENT.stem}{suffix}: its layout has revision 1, installed is 99; version"
        " 0.1.1.dev770+source.g38e4435ed of rigrunner_reports makes it again"
        for suffix in (".html", ".pdf")
    ]
    trusting = Means(run=runs / RUN, runs=runs, registry=registry, trusted=[OLD / "lab.key.pub"])
    assert verify_certificate(ORIGINAL, trusting).unproven == []

    page = tmp_path / AMENDMENT.with_suffix(".html").name
    page.write_bytes(AMENDMENT.with_suffix(".html").read_bytes())
    shown, mark, data = page.read_bytes().partition(b'id="certificate">')
    page.write_bytes(shown.replace(b"0.729", b"0.427") + mark + data)
    resealed(page, lambda content: content)
    checked = verify_certificate(page, means)
    assert any("it does not show '0.729' of its content" in each for each in checked.differences)


def test_results_are_derived_where_only_the_content_has_a_new_revision(runs, tmp_path, monkeypatch):
    monkeypatch.setattr("rigrunner.documents.verifying.revisions.REVISION", 99)
    means = Means(run=runs / RUN, runs=runs, registry=load_registry())
    forged = tmp_path / AMENDMENT.name
    for old, new, differs in (
        (b"", b"", []),
        (b'"printed": "0.729"', b'"printed": "0.427"', ["results/headline/printed: '0.427'"]),
        (b'"verdict": "pass"', b'"verdict": "fail"', ["verdict: 'fail' is recorded, 'pass'"]),
    ):
        forged.write_bytes(AMENDMENT.read_bytes())
        resealed(forged, lambda content, old=old, new=new: content.replace(old, new, 1))
        checked = verify_certificate(forged, means)
        assert any("certificate revision 1, installed 99" in why for why in checked.not_recomputed)
        if revisions()[1] != {1}:  # with a newer method, results cannot be recomputed
            assert any("'template_inverse' revision 1" in why for why in checked.not_recomputed)
            continue
        assert len(checked.differences) == len(differs), checked.differences
        assert all(each in checked.differences[0] for each in differs)


def test_numbers_of_newer_methods_are_not_recomputed(runs):
    registry = with_other_revision("compensation")
    means = Means(run=runs / RUN, runs=runs, registry=registry, letterhead=OLD / "letterhead")
    checked = verify_certificate(AMENDMENT, means)
    assert checked.differences == []
    assert (
        "compensation 'template_inverse' revision 1, installed 99; what was installed then"
        in "".join(checked.not_recomputed)
    )
