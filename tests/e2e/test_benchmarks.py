"""The short form of every benchmark: that it runs, and that its counted work has not grown.

Nothing here looks at a clock: wall time belongs to docs/evidence/performance.md.
"""

import pytest

from benchmarks.command import benchmark, names
from benchmarks.frame import Scale

pytestmark = pytest.mark.figures


LONG = {"report", "acquisition", "start_up", "long_recording", "setpoints", "waiting", "many_steps"}


@pytest.mark.parametrize(
    "name",
    [pytest.param(each, marks=[pytest.mark.thorough] * (each in LONG)) for each in names()],
)
def test_the_counted_work_is_within_its_bound(name):
    work = benchmark(name).work()
    assert work, "a benchmark counts something"
    grown = [f"{one.what}: {one.counted:g} > {one.at_most:g}" for one in work
             if one.counted > one.at_most]  # fmt: skip
    assert not grown
    slack = [one.what for one in work if one.at_most > 10 * one.counted > 0]
    assert not slack, "a bound that far off finds nothing"


@pytest.mark.thorough
@pytest.mark.parametrize("name", names())
def test_the_short_form_runs(name):
    figures = benchmark(name).measure(Scale(short=True))
    assert any(figure.role == "ours" and figure.value for figure in figures)
    assert benchmark(name).__doc__
