import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from rigrunner.signal.averaging import (
    mean_and_without_each,
    median_over_cycles,
    robust_mean,
    trusted,
)

ALL = np.ones(30, bool)


def test_robust_mean_equals_the_plain_mean_of_good_cycles():
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
def test_median_equals_numpy_bit_for_bit(cycles):
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


def test_excluded_cycle_has_no_effect():
    cycles = np.random.default_rng(4).standard_normal((30, 64))
    kept = ALL.copy()
    kept[3] = False
    spoilt = cycles.copy()
    spoilt[3] += 1e6
    np.testing.assert_array_equal(robust_mean(cycles, kept)[0], robust_mean(spoilt, kept)[0])
    assert mean_and_without_each(cycles, kept)[1].shape == (29, 64)


def test_leave_one_out_mean_equals_the_mean_of_the_others():
    cycles = np.random.default_rng(5).standard_normal((30, 16))
    _, without = mean_and_without_each(cycles, ALL, threshold=50.0)
    np.testing.assert_allclose(without[4], np.delete(cycles, 4, axis=0).mean(axis=0))


def test_combined_means_equal_the_separate_ones():
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
