from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from rigrunner.api.analysis import Rejection
from rigrunner.api.data import ZeroReading
from rigrunner.api.errors import DataError
from rigrunner_bearings.api.points import MotionSource, SwingPoint
from rigrunner_bearings.signal.kinematics import swing_angle
from rigrunner_bearings.torque.prepare import prepare_point
from rigrunner_plugins.outlier_rules.rules import Grubbs, pauta
from rigrunner_plugins.outlier_rules.settings import GrubbsSettings
from unit.analysis.helpers_analysis import RATIO, recording, run_of, spec

GRUBBS = Grubbs(GrubbsSettings())
PEAKS = np.array([2.00, 2.02, 1.99, 2.01, 2.03, 1.98, 2.00, 2.01])


def prepared(rec, rule=GRUBBS, **changes):
    return prepare_point(rec, run_of(rec, **changes), spec(), rule)


def without(rec, channel):
    return replace(rec, channels={name: v for name, v in rec.channels.items() if name != channel})


def test_peak_of_every_cycle_is_its_greatest_sample():
    point = prepared(recording(PEAKS))
    # 200 samples a cycle: the greatest is within cos(pi/200) of the true peak
    assert point.peak_nm == pytest.approx(PEAKS, rel=1.3e-4)
    assert point.peak_kept.all()
    assert point.cycles == len(PEAKS)


def test_zero_reading_is_subtracted():
    rec = recording(PEAKS, zero_nm=0.5)
    point = prepared(rec, zeros={"tester.torque": 0.5})
    assert point.peak_nm == pytest.approx(PEAKS, rel=1.3e-4)


def test_recording_has_the_zero_of_its_time():
    rec = recording(PEAKS, zero_nm=0.5)
    recording_zeros = {
        name: {"tester.torque": ZeroReading(zero)} for name, zero in ((rec.name, 0.5), ("b", 0.7))
    }
    point = prepared(rec, zeros={"tester.torque": 0.7}, recording_zeros=recording_zeros)
    assert point.peak_nm == pytest.approx(PEAKS, rel=1.3e-4)


def test_waveforms_are_on_crank_phase():
    point = prepared(recording(np.full(8, 2.0)))
    phase = 2 * np.pi * np.arange(1024) / 1024
    assert point.torque_nm.shape == (8, 1024)
    assert point.torque_nm[3] == pytest.approx(2 * np.cos(phase - np.pi / 3), abs=1e-4)
    assert point.angle_rad.max() == pytest.approx(np.arcsin(2 / 45), rel=1e-4)


def test_angle_offset_is_subtracted():
    rec = recording(PEAKS)
    shifted = replace(
        rec, channels=dict(rec.channels) | {"tester.angle": rec.channels["tester.angle"] + 0.01}
    )
    assert prepared(shifted).angle_rad == pytest.approx(prepared(rec).angle_rad, abs=1e-6)


def test_frequency_comes_from_angle_not_from_entry():
    rec = recording(PEAKS, 10.0)
    entered_wrong = replace(rec, setpoints={"tester.frequency": 12.0, "tester.load": 1000.0})
    point = prepared(entered_wrong)
    assert point.set_frequency_hz == 12.0
    assert point.frequency_hz.value == pytest.approx(10.0, rel=1e-6)
    assert point.frequency_hz.unit == "Hz"
    assert point.frequency_hz.dof == len(PEAKS) - 1


def test_load_is_read_or_else_set_value():
    rec = recording(PEAKS, load_n=1000.0)
    assert prepared(rec).load_n == 1001.5
    assert prepared(replace(rec, conditions={})).load_n == 1000.0


def test_gross_error_is_rejected_from_peaks_and_waveforms():
    peaks = PEAKS.copy()
    peaks[5] = 2.6
    point = prepared(recording(peaks))
    assert [rejection.index for rejection in point.peak_rejections] == [5]
    assert point.peak_rejections[0].value == pytest.approx(2.6, rel=1e-3)
    assert [rejection.index for rejection in point.waveform_rejections] == [5]
    assert point.kept.tolist() == point.peak_kept.tolist() == [k != 5 for k in range(8)]
    assert point.torque_nm.shape[0] == 8  # the data stay


def test_disturbance_away_from_peak_rejects_waveform_only():
    rec = recording(PEAKS)
    torque = rec.channels["tester.torque"].copy()
    torque[740:800] -= 1.0  # 200 samples a cycle from sample 80 on: the fall of cycle 3
    point = prepared(replace(rec, channels=dict(rec.channels) | {"tester.torque": torque}))
    assert [rejection.index for rejection in point.waveform_rejections] == [3]
    assert point.peak_rejections == ()


def test_mean_angle_is_over_kept_cycles():
    peaks = PEAKS.copy()
    peaks[5] = 2.6
    rec = recording(peaks)
    angle = rec.channels["tester.angle"].copy()
    angle[1130:1150] += 0.01  # within cycle 5, away from its ends
    spoiled = prepared(replace(rec, channels=dict(rec.channels) | {"tester.angle": angle}))
    assert not spoiled.kept[5]
    assert spoiled.angle_rad == pytest.approx(prepared(rec).angle_rad, abs=2e-4)


def test_frequency_uncertainty_is_scatter_between_cycles():
    periods = np.linspace(190, 210, 12)  # samples; the first and the last cycle are cut in half
    edges = np.concatenate([[0], np.cumsum(periods)])
    turns = np.interp(np.arange(100, edges[-1] - 100), edges, np.arange(13.0))
    phase = 2 * np.pi * turns
    channels = {"tester.angle": swing_angle(phase, RATIO), "tester.torque": np.cos(phase)}
    frequency = prepared(replace(recording(PEAKS), channels=channels), lambda _: []).frequency_hz
    frequencies = 2000 / periods[1:-1]
    assert frequency.dof == 9
    assert frequency.value == pytest.approx(2000 / periods[1:-1].mean(), rel=1e-3)
    assert frequency.u == pytest.approx(frequencies.std(ddof=1) / np.sqrt(10), rel=0.05)


def test_spikes_are_replaced_and_counted():
    rec = recording(PEAKS)
    torque = rec.channels["tester.torque"].copy()
    torque[[300, 700, 1100]] += 5.0
    point = prepared(replace(rec, channels=dict(rec.channels) | {"tester.torque": torque}))
    assert point.spikes == 3
    assert point.peak_nm == pytest.approx(PEAKS, rel=1e-3)


def test_spikes_remain_without_despike():
    rec = recording(PEAKS)
    torque = rec.channels["tester.torque"].copy()
    torque[700] += 5.0
    spiked = replace(rec, channels=dict(rec.channels) | {"tester.torque": torque})
    point = prepare_point(spiked, run_of(spiked), spec(despike=None), lambda _: [])
    assert point.spikes == 0
    assert point.peak_nm.max() > 3


def test_four_cycles_are_refused():
    with pytest.raises(DataError, match=r"10Hz, tester\.angle: 4 whole cycles, but 5 are needed"):
        prepared(recording(PEAKS[:4]))


def test_too_few_cycles_after_rejection_are_refused():
    def rule(values):
        return [Rejection(k, float(values[k]), "test", 9.0, 1.0) for k in range(4)]

    with pytest.raises(DataError, match=r"tester\.torque: of 8 cycles only 4 remain"):
        prepared(recording(PEAKS), rule)


def test_recording_without_motion_is_refused_by_name():
    rec = recording(PEAKS)
    still = np.full_like(rec.channels["tester.angle"], 0.01)
    with pytest.raises(DataError, match=r"10Hz, tester\.angle: no whole cycle"):
        prepared(replace(rec, channels=dict(rec.channels) | {"tester.angle": still}))


def test_missing_torque_channel_lists_existing_ones():
    with pytest.raises(DataError, match=r"no torque channel; it has tester\.angle in rad"):
        prepared(without(recording(PEAKS), "tester.torque"))


def test_without_motion_channel_cycles_are_cut_by_entered_frequency():
    point = prepared(without(recording(PEAKS), "tester.angle"))
    assert not isinstance(point, SwingPoint)
    assert point.motion is MotionSource.ENTERED
    assert point.frequency_hz.value == 10.0
    # 0.5 % as half-width of a rectangle
    assert point.frequency_hz.u == pytest.approx(0.05 / np.sqrt(3))
    assert point.peak_nm == pytest.approx(PEAKS, rel=1.3e-4)


def test_registered_one_of_two_torque_channels_is_used():
    rec = recording(PEAKS)
    two = replace(
        rec,
        channels=dict(rec.channels) | {"other.torque": 2 * rec.channels["tester.torque"]},
        units=dict(rec.units) | {"other.torque": "N·m"},
    )
    assert prepared(two).peak_nm.max() < 2.1
    with pytest.raises(DataError, match=r"several torque channels: other\.torque, tester\.torque"):
        prepared(two, instruments={})


@pytest.mark.parametrize("channel", ["tester.torque", "tester.angle"])
def test_nan_sample_is_refused(channel):
    rec = recording(PEAKS)
    broken = rec.channels[channel].copy()
    broken[17] = np.nan
    with pytest.raises(DataError, match=f"10Hz, {channel}: a sample is not a finite number"):
        prepared(replace(rec, channels=dict(rec.channels) | {channel: broken}))


def test_missing_set_point_lists_existing_ones():
    with pytest.raises(DataError, match=r"no set-point 'tester\.frequency'; it has tester\.load"):
        prepared(replace(recording(PEAKS), setpoints={"tester.load": 1.0}))


def test_outlier_rule_error_names_the_recording():
    message = "recording 10Hz, tester.torque: pauta, the 3-sigma rule, can reject none of 10 values"
    with pytest.raises(DataError, match=message):
        prepared(recording(np.ones(10)), pauta)
