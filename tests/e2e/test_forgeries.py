"""`verify` on forged, replaced and sealed certificates: docs/evidence/forgeries.md.

Each case is in that table by its name, with its first line and exit code.
"""

from __future__ import annotations

import json
import random
import re
import shutil
from dataclasses import dataclass
from pathlib import Path

import pytest

from e2e.helpers_forgery import (
    appended,
    forged_pdf,
    resealed,
    sealed_pdf,
    with_banner,
    with_content,
)
from e2e.helpers_tamper import RUN_FILE, issue, letterhead
from helpers_cli import call
from helpers_lacking import require_pdf
from rigrunner.documents.verifying.document import read_contents
from rigrunner.documents.verifying.forms import Form
from rigrunner.documents.verifying.verification import Verification
from rigrunner.proof.seal import FORMS

pytestmark = pytest.mark.thorough

PAGE = Path(__file__).parents[2] / "docs" / "evidence" / "forgeries.md"
SEED = 17025
BYTE_COUNTS = {"JSON": 50, "HTML": 50, "PDF": 50, RUN_FILE: 10}
"""Number of changed bytes; fewer of a run file, as a separate process reads each."""
CASES = {}


@dataclass(frozen=True)
class Issued:
    """A run with certificates of two laboratories, the second one amended, and a key."""

    folder: Path
    """The folder of the certificates, to be copied."""
    runs: Path
    letterhead: Path
    other_letterhead: Path
    key: Path
    original: str
    other: str
    amendment: str
    """The amendment of the other certificate."""


@pytest.fixture(scope="module")
def issued(quick_copy):
    require_pdf()
    pytest.importorskip("pyhanko")
    folder, run_folder = quick_copy.folder.parent, quick_copy.loaded
    labs = [letterhead(folder / name) for name in ("lab", "other")]
    entries = labs[1] / "letterhead.yaml"
    entries.write_text(entries.read_text("utf-8").replace("prefix: DEMO", "prefix: OTHER"), "utf-8")
    original, other = (issue(run_folder, lab, folder / "out")[0] for lab in labs)
    assert "OTHER" in other.stem
    amend = ("--reason", "misspelt", "--by", "Z. Head", "--customer", "Example Ltd")
    done = call("amend", other, *amend, "--letterhead", labs[1], "--out", folder / "amended")
    assert done.code == 0, done.err
    assert call("sign", "--new-key", folder / "key").code == 0
    names = (original.stem, other.stem, Path(done.out.split()[0]).stem)
    return Issued(folder / "out", folder / "runs", *labs, folder / "key", *names)


@dataclass(frozen=True)
class Copies:
    """Copies of all issued files, for one case."""

    issued: Issued
    folder: Path

    def path(self, suffix, number=None):
        return self.folder / f"{number or self.issued.original}{suffix}"

    def keep(self, *suffixes):
        """Remove all forms except these."""
        for suffix in FORMS.keys() - set(suffixes):
            self.path(suffix).unlink()

    def verify(self, *words, form=".json", number=None, own=True):
        runs = () if "--runs" in words else ("--runs", self.issued.runs)
        lab = self.issued.other_letterhead if number else self.issued.letterhead
        with_own = ("--letterhead", lab) if own else ()
        return call("verify", self.path(form, number), *runs, *with_own, *words)

    def sign(self):
        """Sign, and return the result of `verify` with that key alone."""
        key, own = self.issued.key, self.issued.letterhead
        words = ("--key", key, "--by", "Z. Head", "--letterhead", own)
        done = call("sign", self.path(".json"), *words)
        if done.code:
            return done
        return self.verify("--trust", f"{key}.pub", own=False)


@pytest.fixture
def copies(issued, tmp_path):
    shutil.copytree(issued.folder, tmp_path, dirs_exist_ok=True)
    return Copies(issued, tmp_path)


def case(name):
    """Register a case under its name in the table."""

    def register(function):
        CASES[name] = function
        return function

    return register


@case("as issued, with the letterhead")
def as_issued(copies):
    return copies.verify()


@case("as issued, without letterhead or key")
def as_issued_alone(copies):
    return copies.verify(own=False)


@case("as issued and signed, with the key alone")
def as_signed(copies):
    return copies.sign()


@case("as issued, without its run")
def without_run(copies):
    return copies.verify("--runs", copies.folder / "none")


@case("forgery A: HTML with another result and a banner, whose data claim another numpy")
def forgery_a(copies):
    def change(page):
        def claim(content):
            content["evidence"]["issued_with"]["numpy"] = "1.0"

        return with_content(with_banner(page), claim)

    resealed(copies.path(".html"), change)
    copies.keep(".html")
    return copies.verify(form=".html", own=False)


@case("forgery B: the same, whose data claim a template of the laboratory's")
def forgery_b(copies):
    resealed(copies.path(".html"), lambda page: with_content(with_banner(page), claim_template))
    copies.keep(".html")
    return copies.verify(form=".html", own=False)


def claim_template(content):
    content["appearance"]["files"]["templates/result.html.j2"] = "0" * 64


@case("forgery B with the letterhead")
def forgery_b_known(copies):
    resealed(copies.path(".html"), lambda page: with_content(with_banner(page), claim_template))
    copies.keep(".html")
    return copies.verify(form=".html")


@case("a page that claims another revision of its layout")
def other_layout(copies):
    def claim(content):
        content["appearance"]["layouts"]["html"] = 99

    resealed(copies.path(".html"), lambda page: with_content(page, claim))
    copies.keep(".html")
    own = shutil.copytree(copies.issued.letterhead, copies.folder / "copy")
    shutil.rmtree(own / "numbers")
    return copies.verify("--letterhead", own, form=".html", own=False)


@case("HTML with another figure")
def other_figure(copies):
    figure = rb'(?<=<img src="data:image/svg\+xml;base64,)[^"]+'
    resealed(copies.path(".html"), lambda page: re.sub(figure, b"PHN2Zy8+", page))
    copies.keep(".html")
    own = shutil.copytree(copies.issued.letterhead, copies.folder / "copy")
    shutil.rmtree(own / "numbers")
    return copies.verify("--letterhead", own, form=".html", own=False)


@case("PDF that contradicts its data, beside a true JSON")
def contradicting_pdf(copies):
    forged_pdf(copies.path(".pdf"))
    return copies.verify(own=False)


@case("a contradicting PDF that is to be signed")
def contradicting_pdf_signed(copies):
    forged_pdf(copies.path(".pdf"))
    return copies.sign()


@case("PDF alone, with the letterhead")
def lone_pdf(copies):
    copies.keep(".pdf")
    return copies.verify(form=".pdf")


@case("PDF alone, without letterhead or key")
def lone_pdf_alone(copies):
    copies.keep(".pdf")
    return copies.verify(form=".pdf", own=False)


@case("HTML of another certificate under this one's name")
def other_page(copies):
    shutil.copyfile(copies.path(".html", copies.issued.other), copies.path(".html"))
    return copies.verify(own=False)


@case("HTML of another certificate that is to be signed")
def other_page_signed(copies):
    shutil.copyfile(copies.path(".html", copies.issued.other), copies.path(".html"))
    return copies.sign()


@case("amendment under the original's name")
def renamed_amendment(copies):
    for suffix in FORMS:
        amended = copies.issued.folder.parent / "amended" / f"{copies.issued.amendment}{suffix}"
        shutil.copyfile(amended, copies.path(suffix, copies.issued.other))
    return copies.verify(number=copies.issued.other)


@case("replaced, by the record of numbers")
def replaced(copies):
    return copies.verify(number=copies.issued.other)


@case("replaced, its amendment beside it")
def replaced_beside(copies):
    shutil.copy(
        copies.issued.folder.parent / "amended" / f"{copies.issued.amendment}.json", copies.folder
    )
    for suffix in (".html", ".pdf"):
        copies.path(suffix, copies.issued.other).unlink()
    return copies.verify(number=copies.issued.other, own=False)


@case("withdrawn, the notice beside it removed")
def withdrawn(copies):
    lab = shutil.copytree(copies.issued.letterhead, copies.folder / "lab")
    words = ("--reason", "the wrong item", "--by", "Z. Head", "--letterhead", lab)
    assert call("withdraw", copies.path(".json"), *words).code == 0
    copies.path(".withdrawn.json").unlink()
    return copies.verify("--letterhead", lab, own=False)


def change_pdf(copies, change):
    path = copies.path(".pdf")
    path.write_bytes(change(path.read_bytes()))
    return copies.verify()


@case("PDF sealed by PAdES after its issue")
def sealed(copies):
    return change_pdf(copies, sealed_pdf)


@case("PDF sealed by PAdES, the seal drawn on its first page")
def sealed_visibly(copies):
    return change_pdf(copies, lambda content: sealed_pdf(content, box=(50, 50, 300, 300)))


@case("PDF whose page was replaced by an update, then sealed by PAdES")
def replaced_then_sealed(copies):
    def replace(writer):
        page = writer.root["/Pages"]["/Kids"][0]
        contents = page["/Contents"]
        contents._data, contents._encoded_data = b"BT ET", None
        writer.update_container(contents)

    return change_pdf(copies, lambda content: sealed_pdf(appended(content, replace)))


@case("numbers by another revision of a method")
def other_revision(copies):
    def claim(content):
        document = json.loads(content)
        document["evidence"]["revisions"]["analysis"] = 99
        return (json.dumps(document, ensure_ascii=False, indent=1) + "\n").encode()

    resealed(copies.path(".json"), claim)
    copies.keep(".json")
    return copies.verify(own=False)


def table():
    """Return exit code and first words by case, from the page."""
    rows = re.findall(r"^\| (.+?) \| `(.+?)` \| (\d+) \|$", PAGE.read_text("utf-8"), re.MULTILINE)
    return {name: (int(code), words) for name, words, code in rows}


def test_table_has_every_case():
    assert set(table()) == {*CASES, *BYTES}


@pytest.mark.parametrize("name", CASES)
def test_case_matches_the_table(name, copies):
    done = CASES[name](copies)
    first = (done.out or done.err).splitlines()[0]
    code, words = table()[name]
    assert (done.code, first[: len(words)]) == (code, words), done
    assert code == 0 or "MATCH" not in first.replace("DOES NOT MATCH", "")


BYTES = {
    f"{count} random bytes, one at a time, of the {form}": form
    for form, count in BYTE_COUNTS.items()
}


@pytest.mark.parametrize("name", BYTES)
def test_each_changed_byte_is_detected(name, copies):
    """Documents by the first stage of `verify`, the run file by `verify` itself."""
    code, words = table()[name]
    assert (code, words) == (1, "DOES NOT MATCH")
    rng, form = random.Random(SEED), BYTES[name]  # noqa: S311  (seeded, to be repeated)
    if form == RUN_FILE:
        (original,) = copies.issued.runs.glob(f"*SSPB-STT*/{RUN_FILE}")
        path = copies.folder / RUN_FILE
        copies.keep(".json")
    else:
        original = path = copies.path(f".{form.lower()}")
    content = original.read_bytes()
    for _ in range(BYTE_COUNTS[form]):
        changed = bytearray(content)
        changed[rng.randrange(len(changed))] ^= rng.randrange(1, 256)
        path.write_bytes(changed)
        if form == RUN_FILE:
            done = copies.verify(path, own=False)
            assert (done.code, done.out.startswith(words)) == (code, True), done
        else:
            verified = Verification()
            read_contents(verified, [Form(path, bytes(changed))])
            assert (verified.exit_code, verified.conclusion.startswith(words)) == (code, True)
