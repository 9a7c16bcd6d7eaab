"""Every command and code block of the README, the tutorials and the how-tos is executed."""

from __future__ import annotations

import json
import os
import re
import shlex
import subprocess
import sys
import tomllib
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path

import h5py
import pytest
import yaml

from e2e.helpers_served import served_command
from helpers_docs import ROOT, code_blocks, links, matches, pages
from helpers_figures import drawn
from helpers_lacking import require_pdf
from rigrunner.api.errors import ExitCode
from rigrunner.api.hooks import HookSpecs
from rigrunner.procedure.kinds import installed_kinds
from rigrunner.runfile import read

RUN_BY_CI = "run by .ci/run, as it stands"
RUN_ELSEWHERE = {
    RUN_BY_CI,
    "run by CI itself: it is the command that runs everything else",
    "run by the reader alone: the test puts this entry point on the path instead",
    "run by the test of the panel, in a browser",
    "run by the test of the loopback, in real time",
    "run by the test of the calibration, in real time",
    "run by the test of the calibration: the run's name is another one",
    "run by the test of the figures",
    "run by the test of the digits",
    "run by the test of the architecture",
    "run by the test of mistakes in a plugin",
    "run by tests/e2e/test_friction_endurance.py",
    "run by the reader alone: it measures for minutes or hours",
    "run by the reader alone: it writes into the sources",
    "run by the reader alone: it lists functions of the sources",
    "run by the reader alone: there is no run that was interrupted where this page is tested",
    "run by the reader alone: no file is damaged where this page is tested",
    "run by the reader alone: there is no such server where this page is tested",
    "run by the reader alone: a part of a procedure",
    "run by the reader alone: a part of a station",
    "run by the reader alone: the rule is in a lab's own folder",
    "run by the reader alone: it is a part of the module that the command makes",
    "run by the reader alone: it needs more runs than there are where this page is tested",
    "run by the reader alone: it needs the runs of three procedures, one after the other",
    "run by the reader alone: there is no such rig where this page is tested",
    "run by the reader alone: the extras are there where this page is tested",
}
IN_ITS_OWN_ENVIRONMENT = {ROOT / "docs/tutorial/first-device-plugin.md"}
"""It installs the package that it creates: test_new_plugin.py runs it."""
SCRIPTS = [
    ROOT / "README.md",
    *sorted(set(ROOT.glob("docs/tutorial/*.md")) - IN_ITS_OWN_ENVIRONMENT),
    *sorted(ROOT.glob("docs/how-to/*.md")),
    ROOT / "docs/evidence/coming-from.md",
]


def relative_name(path):
    return str(path.relative_to(ROOT))


LONG = [
    ROOT / "docs" / f"{page}.md"
    for page in (
        "tutorial/first-certificate",
        "tutorial/first-run",
        "tutorial/panel",
        "explanation/the-paper",
        "how-to/add-a-kind-of-step",
        "how-to/analyse-many-runs",
        "how-to/approve-a-procedure",
        "how-to/bind-a-scpi-instrument",
        "how-to/check-a-plugin",
        "how-to/drive-a-frequency-inverter",
        "how-to/drive-the-panel",
        "how-to/fit-a-curve",
        "how-to/hold-plugins-to-golden-runs",
        "how-to/import-recordings",
        "how-to/issue-a-certificate",
        "how-to/judge-measured-values",
        "how-to/measure-by-an-equation",
        "how-to/queue-specimens",
        "how-to/scan-a-drive",
        "how-to/measure-any-quantity",
        "how-to/record-and-replay",
        "how-to/register-instruments",
        "how-to/replay-recordings",
        "how-to/search-many-runs",
        "how-to/use-a-pymeasure-driver",
        "how-to/verify-a-certificate",
        "how-to/write-a-decision-rule",
        "how-to/write-a-device-plugin",
    )
] + [ROOT / "README.md"]


WITH_QUICK_RUNS = {
    ROOT / "docs/how-to/analyse-many-runs.md",
    ROOT / "docs/how-to/verify-a-certificate.md",
}
"""Pages on which no number of the demonstration is printed, and each command analyses its runs."""


def script(page):
    """Return a page as a parameter; slow ones are marked thorough."""
    return pytest.param(page, id=relative_name(page), marks=[pytest.mark.thorough] * (page in LONG))


@pytest.mark.parametrize("page", [script(page) for page in SCRIPTS])
def test_every_block_of_the_page_works(page, request, served, tmp_path):
    """In one shell, as for a reader: each block starts in the folder in which the last ended."""
    blocks = code_blocks(page)
    if any(".pdf\n" in block.code for block in blocks if block.language == "text"):
        require_pdf()
    install_entry_points(blocks, tmp_path)
    folder, output = tmp_path, ""
    for block in blocks:
        if block.elsewhere:
            assert block.elsewhere in RUN_ELSEWHERE, f"{page}:{block.line}"
        elif block.file:
            (folder / block.file).write_text(block.code, encoding="utf-8")
        elif block.language == "text":
            assert matches(block.code, output), f"{page}:{block.line} does not match\n{output}"
        else:
            if LAB_RUNS in block.code:
                runs = shlex.quote(str(request.getfixturevalue("lab_begun").folder / "runs"))
                copied = f"mkdir runs && cp -r {runs}/*SSPB* runs\n"
                block = replace(block, code=block.code.replace(LAB_RUNS, copied))  # noqa: PLW2901  (the same)
            if DEMO.search(block.code):
                name = "quick" if page in WITH_QUICK_RUNS else "demo"
                copied = copy_of(request.getfixturevalue(name))
                block = replace(block, code=DEMO.sub(copied, block.code))  # noqa: PLW2901  (the same)
            where = f"{page}:{block.line}"
            output, folder = run_block(block, folder, where, lies_in=tmp_path, served=served)


RUN_BY_ANOTHER_TEST = {ROOT / "docs/reference/run-file.md"}


@pytest.mark.parametrize(
    "page",
    [script(page) for page in sorted({*pages()} - {*SCRIPTS, *IN_ITS_OWN_ENVIRONMENT})],
)
def test_every_block_of_the_other_pages_works(page, tmp_path):
    """Except blocks of text: output, and studies that take hours, with their date."""
    for block in code_blocks(page):
        where = f"{relative_name(page)}:{block.line}"
        if block.elsewhere:
            assert block.elsewhere in RUN_ELSEWHERE, where
        elif block.language == "json":
            json.loads(block.code)
        elif block.language not in {"yaml", "text"} and page not in RUN_BY_ANOTHER_TEST:
            execute(block, tmp_path, where)


DEMO = re.compile(r"^rigrunner demo(?: --dir (?P<folder>\S+))?", re.MULTILINE)
"""`.ci/run` runs it twice unchanged; here its folder is copied, as it takes longest."""


LAB_RUNS = (
    "rigrunner run procedures/no_load_inertia_sweep.yaml --station station.yaml --unattended\n"
    "rigrunner run procedures/starting_torque_1000n.yaml --station station.yaml --unattended\n"
)
"""`test_lab.py` runs them unchanged in a new lab folder; here their runs are copied."""


def copy_of(runs):
    return lambda match: (
        f"cp -r {shlex.quote(str(runs.folder))} {match['folder'] or 'rigrunner-demo'}"
    )


@pytest.fixture(scope="module")
def served():
    """Yield the folder of a `rigrunner` that is not imported again for each command."""
    with served_command() as folder:
        yield folder


def execute(block, folder, where):
    return run_block(block, folder, where, lies_in=folder)[0]


def run_block(block, folder, where, lies_in, served=None):
    """Run a block in a folder; return its output, and the folder in which it ended."""
    pwd = lies_in.with_name(f"{lies_in.name}-ended-in")
    runners = {
        "sh": ["bash", "-euo", "pipefail", "-c", f"{block.code}\npwd > {shlex.quote(str(pwd))}"],
        "python": [sys.executable, "-c", block.code],
    }
    assert block.language in runners, f"{where}: no runner for '{block.language}'"
    path = (served, Path(sys.executable).parent, os.environ["PATH"])
    with drawn() if block.language == "python" else nullcontext():  # it may save its own figures
        environment = dict(os.environ)
    environment |= {
        "PATH": os.pathsep.join(map(str, filter(None, path))),
        "PYTHONPATH": os.pathsep.join(filter(None, [str(lies_in), environment.get("PYTHONPATH")])),
        "COLUMNS": "80",
    }
    done = subprocess.run(
        runners[block.language],
        cwd=folder,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        stdin=subprocess.DEVNULL,
        text=True,
        check=False,
    )
    assert done.returncode == 0, f"{where} ended with {done.returncode}\n{done.stdout}"
    if block.language == "sh":
        folder = Path(pwd.read_text(encoding="utf-8").rstrip("\n"))
    return done.stdout, folder


def install_entry_points(blocks, folder):
    """Install the entry points of a page's plugin as `pip install` would, without a network."""
    for block in blocks:
        if block.file == "pyproject.toml":
            project = tomllib.loads(block.code).get("project")
            if project is None:  # a part of one: nothing to install
                continue
            groups = project["entry-points"]
            lines = [
                line
                for group, entries in groups.items()
                for line in (f"[{group}]", *(f"{name} = {at}" for name, at in entries.items()))
            ]
            info = folder / "example-1.0.dist-info"
            info.mkdir()
            (info / "METADATA").write_text("Metadata-Version: 2.1\nName: example\nVersion: 1.0\n")
            (info / "entry_points.txt").write_text("\n".join(lines) + "\n")


def test_ci_runs_the_readme_commands_unchanged():
    first = code_blocks(ROOT / "README.md")[0]
    assert first.elsewhere == RUN_BY_CI
    assert first.code.splitlines() == [
        "python3 -m venv .venv && .venv/bin/pip install . && .venv/bin/rigrunner demo",
        "python3 -m venv .venv && .venv/bin/pip install -e '.[test]' && .venv/bin/pytest",
    ]
    (index_block,) = code_blocks(ROOT / "docs/index.md")
    assert index_block.code == first.code.splitlines(keepends=True)[0]
    script = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    extract = re.search(r"^page_block\(\).*?^}", script, re.MULTILINE | re.DOTALL)[0]
    shown = subprocess.run(
        ["bash", "-c", f"{extract}\npage_block README.md 1"],
        env=os.environ | {"root": str(ROOT)}, capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert shown.stdout == first.code
    assert "run_readme_command 1" in script
    assert "run_readme_command 2" in script


def test_ci_installs_offline_as_documented():
    page = "docs/how-to/install-offline.md"
    blocks = code_blocks(ROOT / page)
    assert [block.elsewhere for block in blocks] == [RUN_BY_CI] * 2
    script = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    extract = re.search(r"^page_block\(\).*?^}", script, re.MULTILINE | re.DOTALL)[0]
    for number, block in enumerate(blocks, 1):
        printed = subprocess.run(
            ["bash", "-c", f"{extract}\npage_block {page} {number}"],
            env=os.environ | {"root": str(ROOT)}, capture_output=True, text=True, check=True,
        )  # fmt: skip
        assert printed.stdout == block.code
        assert f"page_block $page {number}" in script


@pytest.mark.parametrize("page", pages(), ids=relative_name)
def test_every_link_has_a_target(page):
    missing = [
        target for target in links(page) if not (page.parent / target.partition("#")[0]).exists()
    ]
    assert missing == []


def test_readme_is_short():
    page = ROOT / "README.md"
    assert len(page.read_text(encoding="utf-8").splitlines()) <= 110
    assert len(links(page)) <= 3 * 3 + 2 + 10  # three doors, two pictures, ten more


def test_every_decision_is_listed():
    index = ROOT / "docs/decisions/README.md"
    linked = {(index.parent / target).resolve() for target in links(index)}
    assert {page.resolve() for page in index.parent.glob("0*.md")} - linked == set()


def test_every_page_is_listed_on_the_site():
    """The build of the site would fail otherwise; this test needs no Sphinx."""
    text = (ROOT / "docs/index.md").read_text(encoding="utf-8")
    listed = re.findall(r"^[\w-]+(?:/[\w-]+)?$", text, re.MULTILINE)
    assert len(listed) == len(set(listed))
    existing = {
        path.relative_to(ROOT / "docs").with_suffix("") for path in ROOT.glob("docs/**/*.md")
    }
    assert set(map(Path, listed)) == {path for path in existing if on_the_site(path)} - {
        Path("index")
    }


def on_the_site(path):
    return path.parts[0] not in {"decisions", "evidence", "dependencies", "dependencies.md"}


def test_pages_of_the_site_link_only_to_its_pages():
    folder = (ROOT / "docs").resolve()
    of_the_site = {page for page in folder.glob("**/*.md") if on_the_site(page.relative_to(folder))}
    outside = [
        f"{relative_name(page)}: {target}"
        for page in of_the_site
        for target in links(page)
        if target.partition("#")[0].endswith(".md")
        and (page.parent / target.partition("#")[0]).resolve() not in of_the_site
    ]
    assert outside == [], "decisions and evidence are in the sources alone, README is index.md"


@pytest.mark.parametrize("page", pages(), ids=relative_name)
def test_every_yaml_block_is_valid(page):
    for block in code_blocks(page):
        if block.language == "yaml":
            yaml.safe_load(block.code)


def test_documented_exit_codes_match_the_code():
    text = (ROOT / "docs/reference/exit-codes.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| (\d+) \| ([A-Z]+) \|", text, re.MULTILINE)
    assert {(int(code), name) for code, name in rows} == {(c.value, c.name) for c in ExitCode}


def test_every_step_and_option_is_documented():
    text = (ROOT / "docs/reference/procedure-language.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| `(\w+)` \|", text, re.MULTILINE)
    options = ["timeout", "retries", "repeatable", "limits", "on_fail"]
    assert sorted(rows[: -len(options)]) == sorted(installed_kinds().steps)
    assert rows[-len(options) :] == options


def test_every_hook_is_documented():
    text = (ROOT / "docs/reference/hooks.md").read_text(encoding="utf-8")
    rows = set(re.findall(r"^\| `(rigrunner_\w+)` \|", text, re.MULTILINE))
    assert rows == {name for name in vars(HookSpecs) if name.startswith("rigrunner_")}


def test_documented_paths_match_a_run_file(demo):
    text = (ROOT / "docs/reference/run-file.md").read_text(encoding="utf-8")
    paths = re.findall(r"^\| `(/[\w/*]*)` \|", text, re.MULTILINE)
    with h5py.File(demo.loaded / "run.h5") as file:
        existing = {"/", *(f"/{name}" for name in names_of(file))}
        assert file.attrs["rigrunner_format"] == 4
    tops = {path for path in existing if path.count("/") == 2} | {"/", "/entry"}
    of_some_runs = {
        "/entry/imported",
        "/entry/no_load_after",
        "/entry/superseded_measurements",
    }
    assert {path.removesuffix("/*") for path in paths} - of_some_runs == tops


def scripts_of_the_run_file_page():
    blocks = code_blocks(ROOT / "docs/reference/run-file.md")
    scripts = [block for block in blocks if block.language == "python"]
    for block in scripts:
        assert "rigrunner" not in block.code.replace('"rigrunner: manifest/1"', "")
    return scripts


def test_documented_script_checks_the_manifest(demo, tmp_path):
    block, _ = scripts_of_the_run_file_page()
    (tmp_path / "run.h5").write_bytes((demo.loaded / "run.h5").read_bytes())
    assert execute(block, tmp_path, "run-file.md") == "all objects are as the manifest says\n"
    with h5py.File(tmp_path / "run.h5", "r+") as file:
        file["entry/zeros/tester_torque"][()] += 1e-9
    assert "zeros/tester_torque" in execute(block, tmp_path, "run-file.md")


@pytest.mark.parametrize("version", ["now", 1])
def test_documented_script_reads_a_run_without_rigrunner(version, demo, tmp_path):
    _, block = scripts_of_the_run_file_page()
    lines = [line for line in block.code.splitlines() if line.strip()]
    assert len(lines) <= 30
    path = demo.loaded / "run.h5" if version == "now" else OLD_RUN
    (tmp_path / "run.h5").write_bytes(path.read_bytes())
    printed = execute(block, tmp_path, "run-file.md")
    run = read(path)
    result = run.result_document
    assert result is not None
    assert printed.startswith(f"{run.header.run_id} {run.header.procedure_title} completed\n")
    assert printed.endswith(f"verdict {result['decision']['verdict']}\n")
    assert str(dict(run.header.inputs)) in printed
    assert str(run.zeros["tester.torque"]) in printed
    for recording in run.recordings:
        assert f"{recording.name} {{" in printed
        assert all(repr(value) in printed for value in recording.setpoints.values())
        for name, samples in recording.arrays().items():
            span, unit = samples.max() - samples.min(), recording.units[name]
            words = f"{name}: {samples.size} samples, {span:.6g} {unit} peak to peak"
            assert words in printed


OLD_RUN = ROOT / "tests/data/format-1/run.h5"


def names_of(file):
    names = []
    file.visit(names.append)
    return names


@pytest.mark.parametrize(
    ("expected", "output", "same"),
    [
        ("a\nc", "a\nb\nc", True),
        ("c\na", "a\nb\nc", False),
        ("run …_X is …", "run 2026_X is done", True),
        ("1.5", "125", False),
    ],
)
def test_output_is_compared_line_by_line(expected, output, same):
    assert matches(expected, output) is same
