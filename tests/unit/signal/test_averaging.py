import numpy as np
import pytest

from rigrunner.signal.averaging import leave_one_out_means, robust_mean, trusted

ALL = np.ones(30, bool)


def test_equals_mean_and_standard_error_of_good_cycles():
    cycles = np.random.default_rng(1).standard_normal((30, 256))
    mean, error = robust_mean(cycles, ALL, threshold=50.0)
    np.testing.assert_allclose(mean, cycles.mean(axis=0))
    np.testing.assert_allclose(error, cycles.std(axis=0, ddof=1) / np.sqrt(30))


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


def test_identical_cycles_have_no_scatter():
    mean, error = robust_mean(np.ones((10, 8)), np.ones(10, bool))
    assert np.all(mean == 1)
    assert np.all(error == 0)


def test_one_cycle_has_no_standard_error():
    with pytest.raises(ValueError, match="two cycles"):
        robust_mean(np.ones((3, 8)), np.array([True, False, False]))
