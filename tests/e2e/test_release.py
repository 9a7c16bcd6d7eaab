"""The release: sdist and wheel hold exactly what they should, and know their version."""

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
IGNORED = (
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
        listed = output_of(*GIT, "ls-files", "-z", cwd=self.sources)
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


def output_of(*words, cwd):
    done = subprocess.run(words, cwd=cwd, capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"{words}\n{done.stdout}\n{done.stderr}"
    return done.stdout


def built_archive(folder, target, out):
    before = set(out.iterdir())
    output_of(sys.executable, "-m", "hatchling", "build", "-t", target, "-d", out, cwd=folder)
    (archive,) = set(out.iterdir()) - before
    return archive


@pytest.fixture(scope="module")
def release(tmp_path_factory):
    """Tagged sources in their own repository; the wheel is built from the sdist only."""
    if shutil.which("git") is None:
        pytest.skip("there is no git here")
    folder = tmp_path_factory.mktemp("release")
    sources, out = folder / "sources", folder / "out"
    shutil.copytree(ROOT, sources, ignore=shutil.ignore_patterns(*IGNORED))
    out.mkdir()
    output_of(*GIT, "init", "-q", cwd=sources)
    output_of(*GIT, "add", "--all", cwd=sources)
    output_of(*GIT, "commit", "-q", "-m", "all", cwd=sources)
    output_of(*GIT, "tag", f"v{VERSION}", cwd=sources)
    sdist = built_archive(sources, "sdist", out)
    with tarfile.open(sdist) as file:
        file.extraction_filter = getattr(tarfile, "data_filter", None)  # Python 3.11.2 has none
        file.extractall(folder / "unpacked")  # noqa: S202  (we made it)
    wheel = built_archive(folder / "unpacked" / f"rigrunner-{VERSION}", "wheel", out)
    return Release(sources, sdist, wheel)


@pytest.mark.thorough
def test_version_of_sdist_and_wheel_is_the_tag(release):
    assert release.sdist.name == f"rigrunner-{VERSION}.tar.gz"
    assert release.wheel.name == f"rigrunner-{VERSION}-py3-none-any.whl"
    assert release.metadata["Version"] == VERSION


@pytest.mark.thorough
def test_commit_after_the_tag_is_its_own_version(release, tmp_path):
    output_of(*GIT, "clone", "-q", release.sources, tmp_path / "clone", cwd=tmp_path)
    output_of(*GIT, "commit", "-q", "--allow-empty", "-m", "one more", cwd=tmp_path / "clone")
    version = output_of(sys.executable, "-m", "hatchling", "version", cwd=tmp_path / "clone")
    assert re.fullmatch(r"9\.8\.8\.dev1\+g[0-9a-f]+\n", version)


@pytest.mark.thorough
def test_building_leaves_the_sources_unchanged(release):
    assert output_of(*GIT, "status", "--porcelain", "--ignored", cwd=release.sources) == ""
    unpacked = release.sources.parent / "unpacked" / f"rigrunner-{VERSION}"
    assert {path.name for path in unpacked.glob("runner/rigrunner/*.py")} == {
        path.name for path in ROOT.glob("runner/rigrunner/*.py")
    }


@pytest.mark.thorough
def test_wheel_holds_only_the_packages_and_the_procedures(release):
    expected = {"rigrunner/_version.py"}
    for name in release.tracked:
        for package in PACKAGES:
            if name.startswith(f"{package}/"):
                expected.add(name.partition("/")[2])
        if name.startswith("procedures/"):
            expected.add(f"rigrunner/shipped/{name.partition('/')[2]}")
    assert {name for name in release.in_wheel if ".dist-info/" not in name} == expected


@pytest.mark.thorough
def test_sdist_holds_all_sources(release):
    with tarfile.open(release.sdist) as file:
        names = {name.partition("/")[2] for name in file.getnames()}
    assert names == release.tracked | {"PKG-INFO"}


@pytest.mark.thorough
def test_metadata_match_the_project(release):
    metadata, project = release.metadata, PROJECT["project"]
    assert metadata["Name"] == "rigrunner"
    assert metadata["Summary"] == project["description"]
    assert metadata["Requires-Python"] == ">=3.11"
    assert metadata["License-Expression"] == "MIT"
    assert set(metadata.get_all("Provides-Extra")) == set(project["optional-dependencies"])
    needed = [line for line in metadata.get_all("Requires-Dist") if "extra ==" not in line]
    assert len(needed) == len(project["dependencies"])
    assert metadata.get_payload().strip() == (ROOT / "README.md").read_text("utf-8").strip()
    assert b"rigrunner = rigrunner.cli.main:main" in release.information["entry_points.txt"]


@pytest.mark.thorough
def test_wheel_has_every_licence_of_shipped_code(release):
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
def test_installed_wheel_knows_its_version_and_finds_its_plugins(release, tmp_path):
    venv.create(tmp_path / "env", symlinks=sys.platform != "win32")
    paths = {"base": str(tmp_path / "env")}
    site = Path(sysconfig.get_path("purelib", "venv", paths))
    (site / "borrowed.pth").write_text(sysconfig.get_path("purelib") + "\n", encoding="utf-8")
    with zipfile.ZipFile(release.wheel) as file:
        file.extractall(site)  # noqa: S202  (we made it)
    python = Path(sysconfig.get_path("scripts", "venv", paths)) / "python"
    start = (python, "-I", "-m", "rigrunner")
    assert output_of(*start, "--version", cwd=tmp_path) == f"rigrunner {VERSION}\n"
    assert f"rigrunner_plugins {VERSION}" in output_of(*start, "plugins", cwd=tmp_path)


def test_unbuilt_sources_have_a_source_version():
    assert PROJECT["tool"]["hatch"]["version"]["fallback-version"] == rigrunner.__version__
    assert rigrunner.__version__.endswith("+source")
    assert not (ROOT / "runner/rigrunner/_version.py").exists()


def test_citation_names_the_program_and_the_paper():
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


def test_changelog_is_ordered_by_release_and_kind():
    text = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    first, *releases = re.findall(r"^## (.*)$", text, re.MULTILINE)
    assert first == "Unreleased"
    stated = [re.fullmatch(r"(\d+\.\d+\.\d+) - (\d{4}-\d\d-\d\d)", heading) for heading in releases]
    assert all(stated)
    dates = [match[2] for match in stated]
    assert dates == sorted(dates, reverse=True)
    assert stated[0][1] == rigrunner.__version__.removesuffix("+source")
    assert set(re.findall(r"^### (.*)$", text, re.MULTILINE)) <= KINDS


def test_every_dependency_is_documented():
    page = (ROOT / "docs/dependencies.md").read_text(encoding="utf-8").lower()
    extras = PROJECT["project"]["optional-dependencies"].values()
    needed = [*PROJECT["project"]["dependencies"], *(line for extra in extras for line in extra)]
    names = {re.match(r"[\w.-]+", line)[0].lower() for line in needed} - {"rigrunner"}
    rows = " ".join(re.findall(r"^\| (.*?) \|", page, re.MULTILINE))
    assert {name for name in names if not re.search(rf"(?<![\w-]){name}(?![\w-])", rows)} == set()


def test_ci_covers_three_systems():
    text = (ROOT / ".github/workflows/ci.yml").read_text(encoding="utf-8")
    jobs = yaml.safe_load(text)["jobs"]
    linux = [step.get("run") for step in jobs["linux"]["steps"]]
    assert "bash .ci/run" in linux
    systems = jobs["elsewhere"]["strategy"]["matrix"]["os"]
    assert {name.partition("-")[0] for name in systems} == {"windows", "macos"}
    used = re.findall(r"uses: (.*)", text)
    assert used
    for action in used:  # a tag can be moved, and its code runs with our rights
        assert re.fullmatch(r"[\w/-]+@[0-9a-f]{40} # v[\d.]+", action), action
    for path in re.findall(r"\btests/[\w/.]+", text):
        assert (ROOT / path).exists(), path
