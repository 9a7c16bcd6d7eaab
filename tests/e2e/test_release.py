"""What would be published: sdist and wheel hold all that they should, and know their version."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import sysconfig
import tarfile
import tomllib
import venv
import zipfile
from dataclasses import dataclass
from email.parser import Parser
from functools import cached_property
from pathlib import Path

import pytest
import yaml

import rigrunner
from helpers_docs import ROOT

VERSION = "9.8.7"
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
PACKAGES = ("runner", "plugins", "reports")
OF_THIS_MACHINE = (
    ".git", ".venv", "__pycache__", "*.pyc", ".*_cache", ".hypothesis", "*.egg-info",
    "runs", "rigrunner-demo", "dist", "build", "artefacts",
)  # fmt: skip
GIT = ("git", "-c", "user.name=a", "-c", "user.email=a@example.org", "-c", "core.autocrlf=false")


@dataclass(frozen=True)
class Release:
    """The sources under a tag, the sdist made of them, and the wheel made of that."""

    sources: Path
    sdist: Path
    wheel: Path

    @cached_property
    def tracked(self):
        listed = called(*GIT, "ls-files", "-z", cwd=self.sources)
        return {name for name in listed.split("\0") if name}

    @cached_property
    def in_wheel(self):
        with zipfile.ZipFile(self.wheel) as file:
            return {name: file.read(name) for name in file.namelist()}

    @property
    def information(self):
        start = f"rigrunner-{VERSION}.dist-info/"
        return {
            name.removeprefix(start): data
            for name, data in self.in_wheel.items()
            if name.startswith(start)
        }

    @property
    def metadata(self):
        return Parser().parsestr(self.information["METADATA"].decode())


def called(*words, cwd):
    done = subprocess.run(words, cwd=cwd, capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"{words}\n{done.stdout}\n{done.stderr}"
    return done.stdout


def built(folder, target, out):
    before = set(out.iterdir())
    called(sys.executable, "-m", "hatchling", "build", "-t", target, "-d", out, cwd=folder)
    (made,) = set(out.iterdir()) - before
    return made


@pytest.fixture(scope="module")
def release(tmp_path_factory):
    """A tag of sources in a repository of their own: the wheel's come from the sdist alone."""
    if shutil.which("git") is None:
        pytest.skip("there is no git here")
    folder = tmp_path_factory.mktemp("release")
    sources, out = folder / "sources", folder / "out"
    shutil.copytree(ROOT, sources, ignore=shutil.ignore_patterns(*OF_THIS_MACHINE))
    out.mkdir()
    called(*GIT, "init", "-q", cwd=sources)
    called(*GIT, "add", "--all", cwd=sources)
    called(*GIT, "commit", "-q", "-m", "all", cwd=sources)
    called(*GIT, "tag", f"v{VERSION}", cwd=sources)
    sdist = built(sources, "sdist", out)
    with tarfile.open(sdist) as file:
        file.extractall(folder / "unpacked")  # noqa: S202  (we made it; Python 3.11.2 has no filter)
    wheel = built(folder / "unpacked" / f"rigrunner-{VERSION}", "wheel", out)
    return Release(sources, sdist, wheel)


@pytest.mark.thorough
def test_the_version_is_the_tag_in_the_sdist_and_in_the_wheel_made_of_it(release):
    assert release.sdist.name == f"rigrunner-{VERSION}.tar.gz"
    assert release.wheel.name == f"rigrunner-{VERSION}-py3-none-any.whl"
    assert release.metadata["Version"] == VERSION


@pytest.mark.thorough
def test_a_commit_after_the_tag_is_a_version_of_its_own(release, tmp_path):
    called(*GIT, "clone", "-q", release.sources, tmp_path / "clone", cwd=tmp_path)
    called(*GIT, "commit", "-q", "--allow-empty", "-m", "one more", cwd=tmp_path / "clone")
    said = called(sys.executable, "-m", "hatchling", "version", cwd=tmp_path / "clone")
    assert re.fullmatch(r"9\.8\.8\.dev1\+g[0-9a-f]+\n", said)


@pytest.mark.thorough
def test_building_leaves_the_sources_as_they_were(release):
    assert called(*GIT, "status", "--porcelain", "--ignored", cwd=release.sources) == ""
    unpacked = release.sources.parent / "unpacked" / f"rigrunner-{VERSION}"
    assert {path.name for path in unpacked.glob("runner/rigrunner/*.py")} == {
        path.name for path in ROOT.glob("runner/rigrunner/*.py")
    }


@pytest.mark.thorough
def test_the_wheel_holds_the_packages_and_the_procedures_and_nothing_else(release):
    expected = {"rigrunner/_version.py"}
    for name in release.tracked:
        for package in PACKAGES:
            if name.startswith(f"{package}/"):
                expected.add(name.partition("/")[2])
        if name.startswith("procedures/"):
            expected.add(f"rigrunner/shipped/{name.partition('/')[2]}")
    assert {name for name in release.in_wheel if ".dist-info/" not in name} == expected


@pytest.mark.thorough
def test_the_sdist_holds_all_sources(release):
    with tarfile.open(release.sdist) as file:
        names = {name.partition("/")[2] for name in file.getnames()}
    assert names == release.tracked | {"PKG-INFO"}


@pytest.mark.thorough
def test_the_metadata_are_those_of_the_project(release):
    metadata, project = release.metadata, PROJECT["project"]
    assert metadata["Name"] == "rigrunner"
    assert metadata["Summary"] == project["description"]
    assert metadata["Requires-Python"] == ">=3.11"
    assert metadata["License-Expression"] == "MIT"
    assert set(metadata.get_all("Provides-Extra")) == set(project["optional-dependencies"])
    needed = [each for each in metadata.get_all("Requires-Dist") if "extra ==" not in each]
    assert len(needed) == len(project["dependencies"])
    assert metadata.get_payload().strip() == (ROOT / "README.md").read_text("utf-8").strip()
    assert b"rigrunner = rigrunner.cli.main:main" in release.information["entry_points.txt"]


@pytest.mark.thorough
def test_every_licence_of_what_is_shipped_is_in_the_wheel(release):
    vendored = {
        f"{Path(name).parent.as_posix()}/LICENSE"
        for name in release.tracked
        if re.search(r"/vendor/[^/]+/", name)
    }
    assert vendored
    assert set(release.metadata.get_all("License-File")) == {"LICENSE", *vendored}
    for name in ("LICENSE", *vendored):
        assert release.information[f"licenses/{name}"] == (ROOT / name).read_bytes()


@pytest.mark.thorough
def test_the_program_of_the_wheel_says_the_version_and_finds_its_plugins(release, tmp_path):
    venv.create(tmp_path / "env", symlinks=sys.platform != "win32")
    paths = {"base": str(tmp_path / "env")}
    site = Path(sysconfig.get_path("purelib", "venv", paths))
    (site / "borrowed.pth").write_text(sysconfig.get_path("purelib") + "\n", encoding="utf-8")
    with zipfile.ZipFile(release.wheel) as file:
        file.extractall(site)  # noqa: S202  (we made it)
    python = Path(sysconfig.get_path("scripts", "venv", paths)) / "python"
    start = (python, "-I", "-m", "rigrunner")
    assert called(*start, "--version", cwd=tmp_path) == f"rigrunner {VERSION}\n"
    assert f"rigrunner_plugins {VERSION}" in called(*start, "plugins", cwd=tmp_path)


def test_sources_that_nobody_built_say_so():
    assert PROJECT["tool"]["hatch"]["version"]["fallback-version"] == rigrunner.__version__
    assert rigrunner.__version__.endswith("+source")
    assert not (ROOT / "runner/rigrunner/_version.py").exists()


def test_the_citation_names_the_program_and_the_paper():
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert {"cff-version", "message", "title", "authors"} <= set(cited)  # what the format demands
    assert (cited["cff-version"], cited["type"]) == ("1.2.0", "software")
    assert cited["license"] == PROJECT["project"]["license"]
    (paper,) = cited["references"]
    assert {"type", "title", "authors"} <= set(paper)
    readme = " ".join((ROOT / "README.md").read_text(encoding="utf-8").split())
    *first, last = (author["family-names"] for author in paper["authors"])
    assert f"{', '.join(first)} and {last}, *{paper['title']}*" in readme
    where = f"{paper['journal']} {paper['year']}, {paper['volume']}({paper['issue']})"
    assert f"{where}, {paper['start']}, [doi:{paper['doi']}]" in readme


KINDS = {"Added", "Changed", "Deprecated", "Removed", "Fixed", "Security"}


def test_the_changes_are_kept_by_release_and_kind():
    text = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    first, *releases = re.findall(r"^## (.*)$", text, re.MULTILINE)
    assert first == "Unreleased"
    stated = [re.fullmatch(r"(\d+\.\d+\.\d+) - (\d{4}-\d\d-\d\d)", each) for each in releases]
    assert all(stated)
    assert [each[2] for each in stated] == sorted((each[2] for each in stated), reverse=True)
    assert stated[0][1] == rigrunner.__version__.removesuffix("+source")
    assert set(re.findall(r"^### (.*)$", text, re.MULTILINE)) <= KINDS


def test_every_dependency_has_its_line():
    page = (ROOT / "docs/dependencies.md").read_text(encoding="utf-8").lower()
    extras = PROJECT["project"]["optional-dependencies"].values()
    needed = [*PROJECT["project"]["dependencies"], *(each for extra in extras for each in extra)]
    names = {re.match(r"[\w.-]+", each)[0].lower() for each in needed} - {"rigrunner"}
    rows = " ".join(re.findall(r"^\| (.*?) \|", page, re.MULTILINE))
    assert {name for name in names if not re.search(rf"(?<![\w-]){name}(?![\w-])", rows)} == set()


def test_there_is_ci_for_three_systems():
    text = (ROOT / ".github/workflows/ci.yml").read_text(encoding="utf-8")
    jobs = yaml.safe_load(text)["jobs"]
    linux = [step.get("run") for step in jobs["linux"]["steps"]]
    assert "bash .ci/run" in linux
    systems = jobs["elsewhere"]["strategy"]["matrix"]["os"]
    assert {name.partition("-")[0] for name in systems} == {"windows", "macos"}
    used = re.findall(r"uses: (.*)", text)
    assert used
    for action in used:  # a tag can be moved; what is behind it is run with our rights
        assert re.fullmatch(r"[\w/-]+@[0-9a-f]{40} # v[\d.]+", action), action
    for path in re.findall(r"\btests/[\w/.]+", text):
        assert (ROOT / path).exists(), path
