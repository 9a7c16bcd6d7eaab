"""The short form of every benchmark: it runs, and its counted work has not grown.

Nothing here measures time: wall time belongs to docs/evidence/performance.md.
"""

import pytest

from benchmarks.command import benchmark, names
from benchmarks.frame import Scale
from helpers_lacking import require_pdf

pytestmark = pytest.mark.figures


LONG = {"report", "acquisition", "start_up", "long_recording", "setpoints", "waiting", "many_steps"}


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=[pytest.mark.thorough] * (name in LONG)) for name in names()],
)
def test_counted_work_is_within_its_bound(name):
    work = benchmark(name).work()
    assert work, "a benchmark counts something"
    grown = [f"{item.what}: {item.counted:g} > {item.at_most:g}" for item in work
             if item.counted > item.at_most]  # fmt: skip
    assert not grown
    slack = [item.what for item in work if item.at_most > 10 * item.counted > 0]
    assert not slack, "a bound that far off finds nothing"


@pytest.mark.thorough
@pytest.mark.parametrize("name", names())
def test_short_form_runs(name):
    if name == "waiting":
        require_pdf()
    figures = benchmark(name).measure(Scale(short=True))
    assert any(figure.role == "ours" and figure.value for figure in figures)
    assert benchmark(name).__doc__
