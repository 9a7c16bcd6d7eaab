"""The time of whole commands on the demonstration, and the size of a core install.

Each command is a fresh process from its start to its end, compared with a fresh process that does
the minimum of any such program. For `analyse` and `demo` that imports numpy, scipy.special and
h5py. For `certify`, which writes HTML, PDF and JSON, it imports WeasyPrint and makes a page of one
line. `analyse` reads a run and its no-load run, checks their digests, and compensates twelve
set-points by three methods; `demo` records, analyses and reports both runs.

The size is that of the files of all packages that `pip install rigrunner` installs, without extras
and without compiled code of Python.
"""

from __future__ import annotations

import json
import re
import shutil
import tempfile
from functools import partial
from importlib.metadata import PackageNotFoundError, distribution
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING

from packaging.requirements import Requirement

from benchmarks.frame import Figure, Scale, Spread, Work, at_most, fresh, paired

if TYPE_CHECKING:
    from benchmarks.frame import Target

IMPORTS = "import numpy, scipy.special, h5py"
ONE_PAGE = "from weasyprint import HTML; HTML(string='<p>One line.').write_pdf()"
ORDER = (
    *("--not-for-certification", "--authorised-by", "A", "--customer", "B"),
    *("--customer-contact", "C", "--item", "bearing", "--item-condition", "new"),
    *("--received", "2025-11-03"),
)
COUNT = """
import sys
from rigrunner.cli.main import main
main(sys.argv[1:])
print(f"[{len(sys.modules)}]")
"""
MEGA = 1e6


def measure(scale: Scale) -> list[Figure]:
    times = scale.of(9, 1)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        ours = partial(fresh, "-m", "rigrunner")
        imports, page = partial(fresh, "-c", IMPORTS), partial(fresh, "-c", ONE_PAGE)
        ours("init", folder / "lab")
        folders = (folder / f"turn-{turn}" for turn in count())

        def demo() -> None:
            ours("demo", "--dir", next(folders))

        def certify() -> None:
            out = next(folders)  # a folder without certificates
            shutil.copytree(folder / "lab/letterhead", out / "letterhead")
            ours("certify", run, *ORDER, "--letterhead", out / "letterhead", "--out", out)

        demonstration = paired(demo, imports, scale.of(5, 1))
        run = max((folder / "turn-0").iterdir())  # the later run, with load
        analysis = paired(partial(ours, "analyse", run), imports, times)
        floor = Figure("numpy, scipy.special, h5py imported", analysis.floor, "s", "floor")
        return [
            floor,
            figure("rigrunner analyse", analysis, at_most(2.0), ANALYSE),
            figure("rigrunner demo", demonstration, at_most(8.0), DEMO),
            *certificate(paired(certify, page, scale.of(5, 1))),
            size(),
        ]


ANALYSE = (
    "a fourth is imports beyond the floor, an eighth reading, an eighth learning the drive line"
)
DEMO = "two fifths are the analysis; the rest recording, sealing, checking and drawing two runs"


def certificate(pair: object) -> list[Figure]:
    note = "the run is analysed again; the import of WeasyPrint; one PDF and one HTML"
    return [
        Figure("WeasyPrint imported, one page", pair.floor, "s", "floor"),
        figure("rigrunner certify: HTML, PDF, JSON", pair, at_most(2.0), note),
    ]


def figure(what: str, pair: object, target: Target, note: str) -> Figure:
    return Figure(what, pair.ours, "s", ratio=pair.ratio, target=target, note=note)


def size() -> Figure:
    sizes = core_install()
    largest = sorted(sizes, key=sizes.__getitem__, reverse=True)[:3]
    note = ", ".join(f"{name} {sizes[name] / MEGA:.0f}" for name in largest)
    total = Spread.of([sum(sizes.values()) / MEGA])
    return Figure("files of a core install", total, "MB", note=f"{len(sizes)} packages; {note}")


def core_install() -> dict[str, int]:
    """Return the size in bytes of each package of a core install."""
    sizes: dict[str, int] = {}
    remaining = ["rigrunner"]
    while remaining:
        name = re.sub(r"[-_.]+", "-", remaining.pop()).lower()
        if name in sizes:
            continue
        try:
            package = distribution(name)
        except PackageNotFoundError:  # of another platform
            continue
        sizes[name] = sum(map(_bytes, package.files or ()))
        required = map(Requirement, package.requires or ())
        remaining += [
            requirement.name
            for requirement in required
            if requirement.marker is None or requirement.marker.evaluate({"extra": ""})
        ]
    return sizes


def _bytes(file: object) -> int:
    path = Path(file.locate())
    return path.stat().st_size if path.is_file() and path.suffix != ".pyc" else 0


def work() -> list[Work]:
    """Count the imports of a run without an analysis."""
    with tempfile.TemporaryDirectory() as name:
        lab = Path(name) / "lab"
        fresh("-m", "rigrunner", "init", lab)
        run = ("run", lab / "procedures/room_temperature.yaml", "--station", lab / "station.yaml")
        output = fresh("-c", COUNT, *run, "--unattended", "--runs", lab / "runs")
    (modules,) = json.loads(output.splitlines()[-1])
    return [
        Work("modules of a run without an analysis", modules, 930),
        Work("packages of a core install", len(core_install()), 34),
    ]
