"""A brief command leaves the collector as it was, whatever happens."""

import gc

import pytest

from rigrunner.cli.brief import brief_command, short_command


@pytest.fixture(autouse=True)
def unfrozen():
    threshold = gc.get_threshold()
    gc.set_threshold(700, 10, 10)  # Python's own; the tests look for garbage less often
    yield
    gc.set_threshold(*threshold)
    gc.unfreeze()
    gc.enable()


def test_nothing_is_searched_during_a_brief_command_and_what_it_made_not_after():
    before = gc.get_freeze_count()
    with brief_command():
        assert not gc.isenabled()
        kept = [[] for _ in range(1000)]
    assert gc.isenabled()
    assert gc.get_freeze_count() >= before + len(kept)


def test_the_collector_is_back_after_an_error():
    with pytest.raises(KeyError), brief_command():
        raise KeyError
    assert gc.isenabled()


def test_a_collector_that_was_off_stays_off():
    gc.disable()
    with brief_command():
        pass
    assert not gc.isenabled()


def test_a_short_command_searches_seldom_and_not_at_its_end():
    threshold, before = gc.get_threshold(), gc.get_freeze_count()
    with short_command():
        assert gc.isenabled()
        assert gc.get_threshold()[0] > 100 * threshold[0]
        kept = [[] for _ in range(1000)]
    assert gc.get_threshold() == threshold
    assert gc.get_freeze_count() >= before + len(kept)


def test_a_command_is_short_each_time_that_it_is_called():
    @short_command()
    def threshold():
        return gc.get_threshold()[0]

    before = gc.get_threshold()[0]
    assert [threshold() > before, threshold() > before] == [True, True]
    assert gc.get_threshold()[0] == before


def test_the_threshold_is_back_after_an_error():
    threshold = gc.get_threshold()
    with pytest.raises(KeyError), short_command():
        raise KeyError
    assert gc.get_threshold() == threshold
