from __future__ import annotations

from rigrunner.cli.commands.verify import MOST_SHOWN, _first_of_each


def test_first_differences_of_a_check_are_shown_and_the_rest_counted():
    many = [f"result: points/{n}: 1 is recorded, 2 was derived" for n in range(MOST_SHOWN + 5)]
    shown = list(_first_of_each(["seal: changed", *many, "bytes of run.h5: other"]))
    assert shown[0] == "seal: changed"
    assert shown[1 : MOST_SHOWN + 1] == many[:MOST_SHOWN]
    assert shown[-2:] == ["result: and 5 more (--json lists all)", "bytes of run.h5: other"]


def test_few_differences_are_all_shown():
    few = [f"result: {index}" for index in range(MOST_SHOWN)]
    assert list(_first_of_each(few)) == few
