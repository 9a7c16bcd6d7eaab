"""`verify` finds every changed byte of a certificate and of its run file, and where it is.

Some of them here; `python tests/benchmarks/tamper.py` tries two hundred on the demonstration.
"""

from __future__ import annotations

import json
import shutil

import pytest

from e2e.helpers_forgery import resealed
from e2e.helpers_tamper import RUN_FILE, flips, issue, letterhead
from helpers_cli import call


@pytest.fixture(scope="module")
def certified(quick_copy):
    folder = quick_copy.folder.parent
    run_folder = quick_copy.loaded
    return run_folder, issue(run_folder, letterhead(folder / "lab"), folder / "out")


def verified(certified, *words):
    """Verify with the laboratory's letterhead."""
    return call("verify", *words, "--letterhead", letterhead_of(certified))


def letterhead_of(certified):
    return certified[0].parent.parent / "lab" / "letterhead"


@pytest.mark.thorough
def test_every_changed_byte_is_found_and_located(certified, tmp_path):
    run_folder, files = certified
    results = list(flips(files, run_folder, tmp_path / "scratch", count=8, seed=2026))
    assert {flip.file for flip in results} == {RUN_FILE, *(path.name for path in files)}
    assert [flip for flip in results if not flip.found] == []
    assert [flip for flip in results if not flip.placed] == []
    unchanged = verified(certified, tmp_path / "scratch" / files[0].name)
    assert unchanged.code == 0, unchanged.out


@pytest.fixture
def copies(certified, tmp_path):
    """Copy certificate and run, so that a test can change them."""
    run_folder, files = certified
    for path in (*files, run_folder / RUN_FILE):
        shutil.copyfile(path, tmp_path / path.name)
    return next(tmp_path / path.name for path in files if path.suffix == ".json")


@pytest.mark.thorough
def test_certificate_matches_its_run_in_any_place(certified, tmp_path):
    run_folder, files = certified
    for path in files:
        shutil.copyfile(path, tmp_path / path.name)
    certificate = tmp_path / files[0].name
    for words in ([run_folder], [run_folder / RUN_FILE], ["--runs", run_folder.parent]):
        done = verified(certified, certificate, *words)
        assert done.code == 0, done.out
        assert done.out.startswith("MATCH\n")
        assert "certificate regenerated from the run" in done.out
        assert "unsigned: nothing shows who issued it" in done.out


@pytest.mark.thorough
def test_certificate_without_its_run_is_left_open(certified, tmp_path):
    _, files = certified
    for path in files:
        shutil.copyfile(path, tmp_path / path.name)
    done = verified(certified, tmp_path / files[0].name, "--runs", tmp_path / "none")
    assert done.code == 10
    assert "no number was recomputed" in done.out
    assert done.out.startswith("OPEN: nothing differs, but not all could be checked\n")


def test_another_run_is_reported(certified):
    run_folder, files = certified
    other = next(path for path in run_folder.parent.iterdir() if path != run_folder)
    done = call("verify", files[0], other)
    assert done.code == 1
    assert f"the certificate names {run_folder.name}" in done.out


@pytest.mark.thorough
def test_signer_time_and_trust_of_a_signature_are_reported(certified, copies, tmp_path):
    def verified(*words):
        done = call("verify", copies, *words)
        return done.code, done.out

    letterhead = ("--letterhead", letterhead_of(certified))

    for name in ("lab", "other"):
        assert call("sign", "--new-key", tmp_path / f"{name}.key").code == 0
    code, output = verified("--trust", tmp_path / "lab.key.pub")
    assert (code, "DIFFERS  unsigned" in output) == (1, True)
    signed = call("sign", copies, "--key", tmp_path / "lab.key", "--by", "Zoë Head", *letterhead)
    assert signed.code == 0, signed.err
    code, output = verified()
    assert (code, "signed by Zoë Head at 20" in output) == (12, True), "whose key is not known"
    assert verified(*letterhead)[0] == 0
    assert "whether that key is theirs is not known" in output
    code, output = verified("--trust", tmp_path / "lab.key.pub")
    assert (code, "which is trusted" in output) == (0, True)
    code, output = verified("--trust", tmp_path / "other.key.pub")
    assert (code, "not among the trusted keys" in output) == (1, True)
    both = ("--trust", tmp_path / "other.key.pub", "--trust", tmp_path / "lab.key.pub")
    assert verified(*both)[0] == 0


@pytest.mark.thorough
def test_changed_signature_is_reported(certified, copies, tmp_path):
    call("sign", "--new-key", tmp_path / "key")
    letterhead = letterhead_of(certified)
    call("sign", copies, "--key", tmp_path / "key", "--by", "Zoë", "--letterhead", letterhead)
    path = copies.with_suffix(".sig.json")
    path.write_text(path.read_text(encoding="utf-8").replace("Zoë", "Ada"), encoding="utf-8")
    done = call("verify", copies)
    assert (done.code, "the signature is not valid" in done.out) == (1, True)


@pytest.mark.parametrize("name", ["result.json", "report.html"])
def test_file_that_is_no_certificate_is_reported(certified, name):
    done = call("verify", certified[0] / name)
    assert done.code == 5
    assert "is not a certificate: it has neither a seal nor" in done.err
    assert call("verify", certified[0] / "nothing.pdf").code == 2
    other = call("verify", certified[0] / "run.log")
    assert (other.code, "is neither a certificate nor a run" in other.err) == (2, True)
    assert call("verify", certified[0], certified[0]).code == 2


def test_resealed_changed_page_does_not_follow_from_its_content(certified, copies):
    page = copies.with_suffix(".html")
    resealed(page, replacing(b"<td>Example customer</td>", b"<td>Another customer</td>"))
    done = verified(certified, page)
    assert done.code == 1
    assert "OK       seal of" in done.out
    assert "(section 'Customer and item') it shows 'Customer Another customer'" in done.out


def replacing(old, new):
    def change(content):
        assert old in content
        return content.replace(old, new, 1)

    return change


@pytest.mark.thorough
@pytest.mark.parametrize(
    "picture",
    [
        b'<img class="logo" src="x" onerror="document.body.innerHTML = 1">',
        b'<img class="logo" style="inset:0" src="data:image/png;base64,AAAA" alt="">',
        b'<img class="logo" src="data:image/png;base64,AAAA" alt="Passed">',
    ],
)
def test_picture_other_than_the_issued_logo_is_reported(certified, copies, picture):
    """Any such picture could hide the page, or show another one."""
    page = copies.with_suffix(".html")
    resealed(page, replacing(b"<h1", picture + b"\n<h1"))
    for done in (verified(certified, page), call("verify", page)):
        assert done.code == 1
        assert f"{page.name} regenerated from its content" in done.out


@pytest.mark.thorough
def test_duplicate_member_is_reported(copies):
    """Some programs read the first of the two, and this one the last."""
    resealed(copies, replacing(b"{\n", b'{\n "number": "C-2026-9999",\n'))
    done = call("verify", copies)
    assert done.code == 1
    assert "'number' is given twice" in done.out


def test_number_changed_everywhere_does_not_follow_from_the_run(copies):
    content = json.loads(copies.read_text(encoding="utf-8"))
    printed = content["results"]["headline"]["printed"]
    resealed(copies, replacing(f'"printed": "{printed}"'.encode(), b'"printed": "0.7000"'))
    for path in (copies.with_suffix(".html"), copies.with_suffix(".pdf")):
        path.unlink(missing_ok=True)
    done = call("verify", copies)
    assert done.code == 1
    assert "certificate regenerated from the run: results/headline/printed: '0.7000'" in done.out, (
        done.out
    )


@pytest.mark.thorough
def test_pages_are_regenerated_with_the_issued_letterhead(certified, copies):
    done = verified(certified, copies)
    assert (done.code, ".html regenerated from its content" in done.out) == (0, True)
    if copies.with_suffix(".pdf").exists():
        assert ".pdf regenerated from its content" in done.out
    copied = copies.parent / "letterhead"
    shutil.copytree(letterhead_of(certified), copied)
    (copied / "logo.svg").write_text("<svg xmlns='http://www.w3.org/2000/svg'/>", encoding="utf-8")
    done = call("verify", copies, "--letterhead", copied)
    assert done.code == 12
    assert "is not the one it was issued with: logo.svg" in done.out.splitlines()[0]


@pytest.mark.thorough
def test_laboratory_of_another_letterhead_is_reported(certified, copies):
    for path in (copies.with_suffix(".html"), copies.with_suffix(".pdf")):
        path.unlink(missing_ok=True)
    resealed(copies, replacing(b"Demonstration laboratory", b"Accredited laboratory"))
    done = verified(certified, copies)
    assert done.code == 1
    assert "laboratory and statements of the letterhead: laboratory/name" in done.out
