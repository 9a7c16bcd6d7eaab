"""The report of the demonstration, with all its plots: its time, and its size.

Cold: a fresh Python process from its start to its end, including imports, which is given a result
of the demonstration's size (twelve set-points, thirty swings each, three methods, six figures).
Warm: once more in the same process. The command: `rigrunner report` of the demonstration's stored
run, which reads the run, compares its digests and analyses it again before it draws. The floor is a
fresh process that imports jinja2 and matplotlib, fills one table of 36 rows and saves one empty
figure. The long run is hours at 10 kHz: 30,000 swings at each of twelve set-points.

Our sources are compiled beforehand, like those of an installed package. Python does that by default
unless its environment forbids it.
"""

from __future__ import annotations

import tempfile
from functools import partial
from pathlib import Path

from benchmarks.frame import (
    Figure,
    Scale,
    Spread,
    Work,
    at_most,
    calls,
    fresh,
    paired,
    repeated,
)
from rigrunner.api import figures
from rigrunner.api.figures import Axis, Picture
from rigrunner.plots import draw
from rigrunner_reports.render import html
from unit.rigrunner_reports.helpers_report import long_result, report_input

TESTS = Path(__file__).resolve().parent.parent
COLD = f"""
import sys
sys.path.insert(0, {str(TESTS)!r})
from unit.rigrunner_reports.helpers_report import report_input
from rigrunner_reports.render import html
html(report_input())
"""
FLOOR = """
from io import BytesIO
from jinja2 import Environment
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure
rows = [[f"{row * column:.3f}" for column in range(8)] for row in range(36)]
table = "{% for row in rows %}<tr>{% for c in row %}<td>{{ c }}</td>{% endfor %}</tr>{% endfor %}"
Environment(autoescape=True).from_string(table).render(rows=rows)
figure = Figure()
figure.subplots()
FigureCanvasSVG(figure).print_svg(BytesIO())
"""
COLD_S, WARM_S, SIZE_MB = at_most(2.5, "s"), at_most(1.0, "s"), at_most(1.5, "MB")
MEGA = 1e6


def measure(scale: Scale) -> list[Figure]:
    times = scale.of(15, 1)
    if not scale.short:
        fresh("-c", COLD)  # compiles
    cold = paired(partial(fresh, "-c", COLD), partial(fresh, "-c", FLOOR), times)
    result = report_input()
    page = html(result)
    warm = repeated(lambda: html(result), times)
    limit = "matplotlib: text, ticks and layout of 14 panels; a fifth is imports"
    return [
        Figure("imports, one table, one empty figure", cold.floor, "s", "floor"),
        Figure("report, cold", cold.ours, "s", ratio=cold.ratio, target=COLD_S, note=limit),
        Figure("report, warm", warm, "s", target=WARM_S, note=limit),
        *([] if scale.short else [command(times)]),
        size("size, demonstration", page),
        size("size, long run", html(report_input(hours(scale.of(30_000, 500))))),
    ]


def hours(swings: int) -> object:
    return long_result(points=12, cycles=swings, rejected=swings // 50)


def size(what: str, page: bytes) -> Figure:
    note = "marks of plots: bounded, with every extreme" if "long" in what else ""
    return Figure(what, Spread.of([len(page) / MEGA]), "MB", target=SIZE_MB, note=note)


def command(times: int) -> Figure:
    with tempfile.TemporaryDirectory() as folder:
        fresh("-m", "rigrunner", "demo", "--dir", folder)
        run = str(max(Path(folder).iterdir()))  # the later run, with load
        command = ("-m", "rigrunner", "report", run, "--out", f"{folder}/again.html")
        fresh(*command)
        spread = repeated(partial(fresh, *command), times)
    note = "the analysis, done again (two fifths), then imports and plots (a quarter each)"
    return Figure("rigrunner report, cold", spread, "s", target=COLD_S, note=note)


def work() -> list[Work]:
    result = report_input()
    page = html(result)
    once, twice = (html(report_input(hours(swings))) for swings in (1000, 2000))
    return [
        Work("calls of functions for a report", calls(lambda: html(result)), 5_000_000),
        Work("pictures", page.count(b"data:image/svg+xml;base64,"), 6),
        Work("bytes of the report", len(page), 1_000_000),
        Work("bytes of a long run's report", len(once), 1_500_000),
        Work("growth by twice the length", len(twice) / len(once), 1.05),
        Work("drawings for each picture", drawings(), 1),
    ]


def drawings() -> int:
    """Return how often a picture is drawn: once, not again for the layout."""
    count = 0
    plot = draw(Picture("", "", (figures.Figure("", Axis("x"), Axis("y"), ()),)))
    patch = plot.figure.axes[0].patch
    original = patch.draw

    def count_draw(renderer: object) -> None:
        nonlocal count
        count += 1
        original(renderer)

    patch.draw = count_draw  # type: ignore[method-assign]
    assert plot.svg
    return count
