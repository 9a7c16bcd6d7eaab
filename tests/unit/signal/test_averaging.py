import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from rigrunner.signal import averaging
from rigrunner.signal.averaging import (
    leave_one_out_means,
    mean_and_without_each,
    mean_turn,
    median_over_cycles,
    robust_mean,
    trusted,
)

ALL = np.ones(30, bool)


def test_equals_mean_and_standard_error_of_good_cycles():
    cycles = np.random.default_rng(1).standard_normal((30, 256))
    mean, error = robust_mean(cycles, ALL, threshold=50.0)
    np.testing.assert_allclose(mean, cycles.mean(axis=0))
    np.testing.assert_allclose(error, cycles.std(axis=0, ddof=1) / np.sqrt(30))


@given(
    arrays(
        float,
        st.tuples(st.integers(1, 40), st.integers(1, 20)),
        elements=st.one_of(st.floats(-1e300, 1e300), st.sampled_from([0.0, np.nan, np.inf])),
    )
)
def test_the_median_has_the_bits_of_numpys(cycles):
    median, plain = median_over_cycles(cycles), np.median(cycles, axis=0)
    np.testing.assert_array_equal(median, plain)


def test_a_bad_sample_does_not_move_the_mean():
    rng = np.random.default_rng(2)
    cycles = 0.02 * rng.standard_normal((30, 256))
    spoilt = cycles.copy()
    spoilt[7, 100] = 5.0
    assert robust_mean(spoilt, ALL)[0][100] == pytest.approx(cycles[ALL][:, 100].mean(), abs=0.005)
    assert not trusted(spoilt, ALL)[7, 100]


def test_good_samples_are_trusted():
    rng = np.random.default_rng(3)
    for count in (5, 10, 30):
        cycles = rng.standard_normal((count, 1024))
        assert trusted(cycles, np.ones(count, bool)).mean() > 0.9995


def test_a_cycle_that_is_not_kept_has_no_part():
    cycles = np.random.default_rng(4).standard_normal((30, 64))
    kept = ALL.copy()
    kept[3] = False
    spoilt = cycles.copy()
    spoilt[3] += 1e6
    np.testing.assert_array_equal(robust_mean(cycles, kept)[0], robust_mean(spoilt, kept)[0])
    assert leave_one_out_means(cycles, kept).shape == (29, 64)


def test_leaving_out_equals_the_mean_of_the_rest():
    cycles = np.random.default_rng(5).standard_normal((30, 16))
    without = leave_one_out_means(cycles, ALL, threshold=50.0)
    np.testing.assert_allclose(without[4], np.delete(cycles, 4, axis=0).mean(axis=0))


def test_both_means_at_once_have_the_bits_of_each():
    cycles = np.random.default_rng(5).standard_normal((30, 16))
    cycles[7, 3] = 1e3
    kept = ALL.copy()
    kept[[2, 9]] = False
    mean, without = mean_and_without_each(cycles, kept)
    np.testing.assert_array_equal(mean, robust_mean(cycles, kept)[0])
    assert without.shape == (28, 16)
    trust = trusted(cycles, kept)
    for row, left_out in zip(without, np.flatnonzero(kept), strict=True):
        others = trust & (np.arange(30) != left_out)[:, None]
        np.testing.assert_allclose(row, np.mean(cycles, axis=0, where=others), rtol=1e-12)


def test_identical_cycles_have_no_scatter():
    mean, error = robust_mean(np.ones((10, 8)), np.ones(10, bool))
    assert np.all(mean == 1)
    assert np.all(error == 0)


def test_one_cycle_has_no_standard_error():
    with pytest.raises(ValueError, match="two cycles"):
        robust_mean(np.ones((3, 8)), np.array([True, False, False]))
    with pytest.raises(ValueError, match="two cycles"):
        mean_and_without_each(np.ones((3, 8)), np.array([True, False, False]))


def plain_mean_turn(values, starts, parts):
    """Return the mean of the parts, one by one."""
    means = []
    for begin, end in itertools.pairwise(starts):
        period = end - begin
        edges = [round(begin + period * (k / parts)) for k in range(parts)] + [round(end)]
        means.append([values[a:b].mean() for a, b in itertools.pairwise(edges)])
    return np.mean(means, axis=0)


@given(
    first=st.floats(0, 50),
    periods=st.lists(st.floats(65, 300), min_size=1, max_size=40),
    parts=st.integers(1, 64),
)
def test_a_mean_turn_is_that_of_its_parts_one_by_one(first, periods, parts):
    starts = first + np.concatenate([[0.0], np.cumsum(periods)])
    values = np.random.default_rng(3).standard_normal(int(starts[-1]) + 2)
    mean = mean_turn(values, starts, parts)
    assert mean == pytest.approx(plain_mean_turn(values, starts, parts), abs=1e-12)


def test_a_mean_turn_of_very_many_cycles_is_the_same(monkeypatch):
    values, starts = np.random.default_rng(3).standard_normal(9000), np.arange(0, 9000, 100.5)
    mean = mean_turn(values, starts, 16)
    monkeypatch.setattr(averaging, "AT_ONCE", 64)
    assert mean_turn(values, starts, 16) == pytest.approx(mean, rel=1e-12)


def test_a_mean_turn_of_a_harmonic_is_smaller_by_what_is_said():
    phase = 2 * np.pi * np.arange(64_000) / 6400
    mean = mean_turn(np.sin(5 * phase), np.arange(0, 64_001, 6400.0), 64)
    amplitude = np.abs(np.fft.rfft(mean)[5]) / 32
    assert amplitude == pytest.approx(np.sinc(5 / 64), rel=1e-4)


def test_a_part_without_a_sample_is_refused():
    with pytest.raises(ValueError, match="needs cycles of 64 samples"):
        mean_turn(np.ones(200), np.array([0.0, 63.5, 130.0]), 64)
    with pytest.raises(ValueError, match="needs cycles of 64 samples"):
        mean_turn(np.ones(200), np.array([0.5, 64.5, 128.5]), 64)  # 1.5 and 2.5 round to 2
