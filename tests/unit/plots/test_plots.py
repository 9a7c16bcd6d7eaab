"""Drawing of figures."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from io import BytesIO
from itertools import pairwise

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib import style
from matplotlib.figure import Figure as Canvas

from rigrunner.api.errors import UsageError
from rigrunner.api.figures import Axis, Figure, Mark, Picture, Point, Series
from rigrunner.plots import draw
from rigrunner.plots.panels import LINES, STYLE, WIDTH_IN, height_in, limit_lines, paint

pytestmark = pytest.mark.figures

X, Y = Axis("t", "s"), Axis("torque", "N·m")


def picture(*series, marks=(), x=X, **more):
    return Picture("caption", "alt", (Figure("$a$ & <b>", x, Y, series, marks),), **more)


EVERY_KIND = picture(
    Series.over([1, 2, 3], [2.0, 3.0, 2.5], "a", "joined", U=[0.1, float("nan"), 0.2]),
    Series.over([1, 2, 3], [1.0, 1.1, 1.2], "b", "line", U=[0.1, 0.1, 0.1]),
    Series.over([1, 2, 3], [1.0, 1.5, 1.2], "c", "bars"),
    Series.over([2], [5.0], "d", "excluded"),
    Series.over([2], [5.0], "e", "marked"),
    Series("f", (Point(1.0, 2.0, lower=0.5), Point(2.0, 9.0, 1.0, upper=3.0, missed=True))),
    marks=(Mark("y", 0.0), Mark("x", 1.5, 2.5, "g"), Mark("y", 4.0, name="h", is_limit=True)),
)


def axes_of(shown):
    return draw(shown).figure.axes


def legend_of(shown):
    (legend,) = draw(shown).figure.legends
    return {text.get_text() for text in legend.get_texts()}


def test_named_series_and_marks_are_in_the_legend():
    assert legend_of(EVERY_KIND) == {*"abcdefgh", "limit", "not passed"}


def test_plot_is_shown_in_a_notebook_and_saved(tmp_path):
    plot = draw(EVERY_KIND)
    assert ET.fromstring(plot._repr_svg_()).tag.endswith("svg")  # noqa: S314  (our own figure)
    for name in ("a.svg", "a.png", "a.pdf"):
        plot.save(tmp_path / name)
        assert (tmp_path / name).stat().st_size > 1000
    with pytest.raises(UsageError, match="cannot be written"):
        plot.save(tmp_path / "a.nothing")


def test_user_settings_of_matplotlib_are_ignored_and_restored():
    plain = draw(EVERY_KIND).svg
    with mpl.rc_context({"font.size": 30, "axes.facecolor": "red", "svg.fonttype": "none"}):
        user_settings = dict(mpl.rcParams)
        assert draw(EVERY_KIND).svg == plain
        assert dict(mpl.rcParams) == user_settings


def test_svg_has_no_date():
    assert b"dc:date" not in draw(EVERY_KIND).svg


def test_svg_equals_that_of_savefig():
    """`draw` lays a figure out once instead of twice, and gives the same bytes."""
    with style.context(["default", STYLE]):
        figure = Canvas(figsize=(WIDTH_IN, height_in(EVERY_KIND)), layout="constrained")
        paint(figure, EVERY_KIND)
        figure.savefig(buffer := BytesIO(), format="svg", metadata={"Date": None})
    assert draw(EVERY_KIND).svg == buffer.getvalue()


def test_series_of_the_same_name_look_alike_in_all_panels():
    a, b = (Series.over([1, 2], [1, 2], name, "line") for name in "ab")
    panels = (Figure("", X, Y, (a, b)), Figure("", X, Y, (b,)))
    first, second = axes_of(Picture("", "", panels, in_a_row=True))
    assert second.lines[0].get_color() == first.lines[1].get_color() != first.lines[0].get_color()


def test_series_can_be_distinguished_without_colour():
    assert len({(line.dashes, line.marker) for line in LINES}) == len(LINES)


def test_constant_limits_span_the_axis_and_others_follow_x():
    def lines_of(*limits):
        return list(limit_lines(Point(x, 0.0, lower=0.0, upper=end) for x, end in limits))

    assert lines_of((1, 5.0), (2, 5.0)) == [([], [0.0]), ([], [5.0])]
    assert lines_of((2, 6.0), (1, 5.0)) == [([], [0.0]), ([1, 2], [5.0, 6.0])]
    assert lines_of((1, None), (2, float("inf"))) == [([], [0.0])]


def test_limit_of_some_points_is_a_short_line_at_each():
    """Limits at 32 and 212 do not apply at 70: no line connects them."""
    limits = {32.0: (99.8, 100.2), 70.0: (None, None), 212.0: (None, 200.0)}
    points = [Point(x, 100.0, lower=low, upper=high) for x, (low, high) in limits.items()]
    assert list(limit_lines(points)) == [
        ([28.4, 35.6], [99.8, 99.8]),
        ([28.4, 35.6], [100.2, 100.2]),
        ([208.4, 215.6], [200.0, 200.0]),
    ]


def test_limit_of_all_points_spans_the_axis_beside_a_series_without_limits():
    limited = Series("R", (Point(1.0, 2.0, upper=3.0), Point(2.0, 2.5, upper=3.0)))
    (axes,) = axes_of(picture(limited, Series.over([1.0, 1.5, 2.0], [2, 2, 2], "fit", "line")))
    assert any(set(line.get_ydata()) == {3.0} and line.get_xdata()[0] == 0 for line in axes.lines)


def test_axis_has_the_given_ends():
    (axes,) = axes_of(picture(Series.over([1, 2], [3, 4]), x=Axis("x", low=0.0, high=10.0)))
    assert axes.get_xlim() == (0.0, 10.0)


def test_uncertainty_bars_are_within_the_axis():
    (axes,) = axes_of(picture(Series.over([1, 2], [3, 4], U=[0.5, 2.0])))
    low, high = axes.get_ylim()
    assert low < 2.0
    assert high > 6.0


@pytest.mark.parametrize("unit", ["V/A", "m·s"])
def test_compound_unit_is_in_brackets(unit):
    assert str(Axis("q", unit)) == (f"q / ({unit})" if "/" in unit else f"q / {unit}")


def test_ticks_have_the_decimal_sign_of_the_document():
    (axes,) = axes_of(picture(Series.over([0.5, 1.5], [-0.5, 0.5]), decimal=","))
    texts = [label.get_text() for label in axes.get_yticklabels()]
    assert any("," in text for text in texts)
    assert not any("." in text or "-" in text for text in texts)


def test_time_is_shown_as_dates():
    day = 86400.0
    over = Series.over([0.0, 365 * day], [1.0, 2.0])
    (axes,) = axes_of(picture(over, x=Axis("start", is_time=True)))
    assert axes.xaxis.get_major_formatter()(day, 0) == "1970-01-02"


@pytest.mark.parametrize(
    ("count", "name", "shown"),
    [(12, "35 Hz", 12), (16, "35 Hz", 16), (17, "35 Hz", 9), (200, "3.22111 Hz", 9)],
)
def test_tick_names_do_not_overlap(count, name, shown):
    x = Axis("x", ticks=tuple((place, name) for place in range(count)))
    plot = draw(picture(Series.over(range(count), np.zeros(count)), x=x))
    plot.svg  # noqa: B018  (lays it out)
    boxes = [label.get_window_extent() for label in plot.figure.axes[0].get_xticklabels()]
    assert len(boxes) == shown
    assert all(left.x1 < right.x0 for left, right in pairwise(boxes))


def test_series_of_unequal_columns_is_refused():
    with pytest.raises(ValueError, match="shorter"):
        Series.over([1, 2], [1, 2], U=[0.1])


@pytest.mark.parametrize("longest", [5, 25, 60, 100])
def test_legend_is_within_the_figure(longest):
    names = ["n" * longest, *("m" * 15 for _ in "ab"), "a", "b"]
    plot = draw(picture(*(Series.over([1], [1], f"{i}{n}") for i, n in enumerate(names))))
    plot.svg  # noqa: B018  (lays it out)
    box = plot.figure.legends[0].get_window_extent()
    assert box.x0 >= 0
    assert box.x1 <= plot.figure.bbox.x1
