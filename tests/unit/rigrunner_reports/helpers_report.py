"""A plausible made-up result for tests of reports: no device, no engine, no analysis.

The torque is J alpha + support friction + bearing friction with a known truth, so that the
values of a report can be computed by hand.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import inf, sqrt

import numpy as np

from rigrunner.api.analysis import Check, Component, Rejection
from rigrunner.api.data import Estimate, Points, RunData
from rigrunner.api.instruments import Instrument
from rigrunner.api.results import ReportInput, Result
from rigrunner.api.verdict import Decision, LimitDecision, Limits, Verdict
from rigrunner_bearings.api.compensations import CompensatedPoint, Compensation, Trace
from rigrunner_bearings.api.measurand import Condition, MeasurandKind, Nature
from rigrunner_bearings.api.points import SwingPoint
from rigrunner_bearings.api.torque import FittedTorque, TorqueDetails
from rigrunner_bearings.signal.kinematics import angular_acceleration, angular_velocity, swing_angle

FREQUENCIES = (1.0, 3.0, 5.0, 8.0, 10.0, 15.0, 18.0, 20.0, 25.0, 30.0, 33.0, 35.0)
RATIO = 2 / 45
TRUTH_NM = 0.7262
J_KGM2 = 0.002324
PHASES = 256
PHASE = 2 * np.pi * np.arange(PHASES) / PHASES

RIG_KEYS = {
    "mandrel": "M-01",
    "eccentric": "2 mm",
    "centre_distance": "45 mm",
    "inertia": "0.00233 kg·m²",
    "support_friction": "0.76 N·m",
    "support_damping": "0.31 N·m·s/rad",
    "swing_radius": "10.4 mm",
}
INSTRUMENT = Instrument.model_validate(
    {
        "channel": "tester.torque",
        "maker": "Example",
        "type": "T-10",
        "serial": "TQ-4711",
        "certificate": "C-2026-001",
        "laboratory": "Example laboratory",
        "calibrated": "2026-01-15",
        "due": "2027-01-15",
        "full_scale": "10 N·m",
        "accuracy": {
            "gain": "0.3 %",
            "offset": "0.02 N·m",
            "drift": "0.02 N·m",
            "nonlinearity": "0.05 %",
        },
        "low_pass": {"type": "butterworth", "order": 2, "corner": "1 kHz"},
    }
)


@dataclass(frozen=True, eq=False)
class PolynomialCurve:
    """An ordinary least-squares polynomial as a Curve."""

    points: Points
    degree: int
    names: tuple[str, ...]
    units: tuple[str, ...]
    formula: str

    @property
    def _design(self):
        return self.points.x[:, None] ** np.arange(self.degree + 1)

    @property
    def coefficients(self):
        return np.linalg.lstsq(self._design, self.points.y, rcond=None)[0]

    @property
    def residuals(self):
        return self.points.y - self._design @ self.coefficients

    @property
    def dof(self):
        return float(len(self.points.x) - self.degree - 1)

    @property
    def residual_s(self):
        return float(np.sqrt(np.sum(self.residuals**2) / self.dof))

    @property
    def covariance(self):
        return np.linalg.inv(self._design.T @ self._design) * self.residual_s**2

    @property
    def r_squared(self):
        return float(1 - np.var(self.residuals) / np.var(self.points.y))

    @property
    def valid_x(self):
        return float(self.points.x.min()), float(self.points.x.max())

    def predict(self, x):
        rows = np.asarray(x)[:, None] ** np.arange(self.degree + 1)
        variance = np.einsum("ij,jk,ik->i", rows, self.covariance, rows)
        return rows @ self.coefficients, np.sqrt(variance)


def friction(phase, level_nm, growth_rad):
    """Return friction that changes its sign within about `growth_rad` after each reversal."""
    angle = swing_angle(phase, RATIO)
    top = np.arcsin(RATIO)
    rising = np.cos(phase) > -RATIO
    travel = np.where(rising, angle + top, top - angle)
    return level_nm * np.where(rising, 1, -1) * (1 - 2 * np.exp(-travel / growth_rad))


def waveforms(frequency_hz, load_n):
    """Return (rig, bearing) torque over one swing, shape (PHASES,) each."""
    rig = J_KGM2 * angular_acceleration(PHASE, frequency_hz, RATIO)
    rig += friction(PHASE, 0.76, 0.003) * (
        1 + 0.4 * np.abs(angular_velocity(PHASE, frequency_hz, RATIO))
    )
    return rig, friction(PHASE, TRUTH_NM * load_n / 1000, 0.002)


def swing_point(frequency_hz, load_n, *, cycles=30, outlier=None):
    rng = np.random.default_rng([int(frequency_hz), int(load_n)])
    rig, bearing = waveforms(frequency_hz, load_n)
    torque = rig + bearing + rng.normal(0, 0.02, (cycles, PHASES))
    kept, rejections = np.ones(cycles, bool), ()
    if outlier is not None:
        torque[outlier] += 0.4
        kept[outlier] = False
        rejections = (Rejection(outlier, 0.4, "grubbs", 4.81, 2.908),)
    peaks = torque.max(axis=1)
    peak_rejections = tuple(
        replace(rejection, value=float(peaks[rejection.index])) for rejection in rejections
    )
    return SwingPoint(
        recording=f"{frequency_hz:g} Hz",
        set_frequency_hz=frequency_hz,
        frequency_hz=Estimate(frequency_hz * 1.0004, 1e-4 * frequency_hz, cycles - 1.0, "Hz"),
        load_n=load_n,
        sample_rate_hz=10000.0,
        angle_rad=swing_angle(PHASE, RATIO),
        torque_nm=torque,
        kept=kept,
        waveform_rejections=rejections,
        peak_nm=peaks,
        peak_kept=kept,
        peak_rejections=peak_rejections,
        spikes=3,
    )


def run_data(run_id, procedure_id, title, **changes):
    run = RunData(
        run_id=run_id,
        procedure_id=procedure_id,
        procedure_revision="A",
        procedure_title=title,
        station_id="simulated",
        started_utc="2026-03-02T09:15:00Z",
        ended_utc="2026-03-02T09:31:30Z",
        outcome="completed",
        inputs={"specimen": "DEMO-0001", "operator": "Demo operator"},
        rig_keys=RIG_KEYS,
        instruments={"tester.torque": INSTRUMENT},
        zeros={"tester.torque": 0.0123},
        recordings=(),
        digest="3f" * 32,
    )
    return replace(run, **changes)


def mean_peaks(points):
    peaks = [point.peak_nm[point.peak_kept] for point in points]
    return Points(
        x=np.array([point.frequency_hz.value for point in points]),
        y=np.array([values.mean() for values in peaks]),
        u_y=np.array([values.std(ddof=1) / np.sqrt(len(values)) for values in peaks]),
    )


def fits(points):
    peaks = mean_peaks(points)
    polynomial = PolynomialCurve(
        peaks, 2, ("c0", "c1", "c2"), ("N·m", "N·m/Hz", "N·m/Hz²"), "T = c0 + c1·f + c2·f²"
    )
    straight = FittedTorque("straight", peaks, None, problem="two points are not enough here")
    return FittedTorque("polynomial", peaks, polynomial), straight


SUPPORT = Component(
    "support friction under load",
    0.004,
    inf,
    "rectangular",
    common=True,
    value=0.0,
    unit="1",
    input_u=0.01 / sqrt(3),
    sensitivity=-0.69,
)


def components(error_nm):
    return (
        Component("scatter between cycles", 0.002, 29.0, "t", common=False),
        Component("sensor gain", 0.0013, inf, "rectangular", common=True),
        Component("zero drift", 0.0058, inf, "rectangular", common=True),
        Component("rig model", 0.004 + abs(error_nm) / 4, inf, "rectangular", common=True),
    )


def compensated(point, error_nm, *, traced=True):
    raw = float(point.peak_nm[point.peak_kept].mean())
    torque, parts = TRUTH_NM + error_nm, components(error_nm)
    rig, bearing = waveforms(point.set_frequency_hz, point.load_n)
    u = float(np.sqrt(sum(part.u**2 for part in parts)))
    return CompensatedPoint(
        set_frequency_hz=point.set_frequency_hz,
        frequency_hz=point.frequency_hz.value,
        raw_nm=raw,
        rig_nm=raw - torque,
        torque=Estimate(torque, u, 400.0),
        components=parts,
        trace=Trace(point.angle_rad, rig + bearing, rig, bearing) if traced else None,
    )


TEMPLATE_ERRORS = (
    -0.003,
    0.001,
    0.002,
    -0.001,
    0.004,
    0.003,
    -0.002,
    0.0,
    0.005,
    -0.004,
    0.002,
    0.006,
)
PAPER_ERRORS = (-0.163, -0.09, -0.04, -0.01, 0.02, 0.05, 0.06, 0.08, 0.1, 0.13, 0.15, 0.165)


def compensations(points):
    return {
        "paper_peak": Compensation(
            "starting torque as the difference of raw peaks (Eq. 2 of the paper)",
            tuple(
                compensated(point, error, traced=False)
                for point, error in zip(points, np.resize(PAPER_ERRORS, len(points)), strict=True)
            ),
            notes=("Assumes that the loaded and the no-load peak fall at the same phase.",),
        ),
        "template_inverse": Compensation(
            "load-induced starting torque",
            tuple(
                compensated(point, error)
                for point, error in zip(
                    points, np.resize(TEMPLATE_ERRORS, len(points)), strict=True
                )
            ),
            parameters={
                "J": Estimate(J_KGM2, 4e-6, 40.0, "kg·m²"),
                "fn": Estimate(400.3, 0.6, 40.0, "Hz"),
            },
            checks=(
                Check("asymmetry", ok=True, text="both directions agree within 5 %"),
                Check(
                    "resonance",
                    ok=False,
                    text="the resonance fell from 440 Hz to 400 Hz",
                    advice="tighten the coupling",
                ),
            ),
        ),
        "energy": Compensation(
            "running torque",
            tuple(compensated(point, -0.09, traced=False) for point in points),
            notes=("The area of the friction loop: another quantity.",),
        ),
        "tacho_only": Compensation(
            "load-induced starting torque", (), not_applicable="there is no tacho channel"
        ),
    }


torque_of = TorqueDetails.of


def changed(result, **changes):
    """Return a copy of the result with changed fields, its own or those of its torque details."""
    names = {name for name in TorqueDetails.__dataclass_fields__ if name in changes}
    torque = replace(TorqueDetails.of(result), **{name: changes.pop(name) for name in names})
    return replace(result, details=(torque,), **changes)


def loaded_result(**changes):
    """Return the result of a loaded run with its no-load run."""
    loaded = tuple(swing_point(f, 1000.0, outlier=7 if f == 8 else None) for f in FREQUENCIES)
    no_load = tuple(swing_point(f, 0.0) for f in FREQUENCIES)
    no_load_run = run_data("20260302T085000Z_SSPB-NLI", "SSPB-NLI", "No-load inertia sweep")
    result = Result(
        run=run_data(
            "20260302T091500Z_SSPB-STT-1000_DEMO-0001",
            "SSPB-STT-1000",
            "Starting torque under 1000 N",
            partners={"no_load": no_load_run},
        ),
        measurand="load-induced starting torque",
        symbol="Td",
        details=(
            TorqueDetails(
                loaded=loaded,
                no_load=no_load,
                fits=fits(no_load),
                compensations=compensations(loaded),
                primary="template_inverse",
                kind=MeasurandKind(Nature.LOAD_INDUCED, Condition.AT_REVERSAL),
                headline=Estimate(0.7274, 0.0062, 900.0),
                headline_components=(SUPPORT,),
                raw_headline=Estimate(3.4567, 0.0123, inf),
            ),
        ),
        decision=Decision(
            rule="guard_band_u: pass only if the value is inside by U",
            parts=(
                LimitDecision(
                    verdict=Verdict.PASS,
                    reason="Margin to the limit ≤ 0.95 N·m: 0.2226 N·m (U = 0.0122 N·m).",
                    limits=Limits.between(None, 0.95),
                    source="demonstration only",
                    probability=1.0,
                    uncompensated=Verdict.FAIL,
                ),
            ),
        ),
        checks=(
            Check("zero drift", ok=True, text="zero readings of both runs agree within 0.02 N·m"),
            Check("cycles", ok=False, text="8 Hz 9 cycles", advice="record 30 cycles"),
        ),
        settings={
            "despike": {"window": 11},
            "outliers": {"name": "grubbs", "settings": {"alpha": 0.05}},
            "compensations": [
                {"name": "template_inverse", "settings": {"support_load_dependence": 0.01}}
            ],
            "primary": "template_inverse",
        },
    )
    return changed(result, **changes)


def long_result(*, points, cycles, rejected):
    """Return the result of a run with these numbers of set-points, cycles and rejections."""
    loaded, no_load = (
        tuple(
            _longer(swing_point(float(frequency), load_n, outlier=7), cycles, rejected)
            for frequency in np.linspace(1, 35, points)
        )
        for load_n in (1000.0, 0.0)
    )
    return loaded_result(
        loaded=loaded, no_load=no_load, fits=fits(no_load), compensations=compensations(loaded)
    )


def _longer(point, cycles, rejected):
    rng = np.random.default_rng(cycles)
    kept = np.ones(cycles, bool)
    kept[rng.permutation(cycles)[:rejected]] = False
    rejections = tuple(
        replace(point.peak_rejections[0], index=int(index), statistic=3 + rng.random())
        for index in np.flatnonzero(~kept)
    )
    return replace(
        point,
        torque_nm=np.broadcast_to(point.torque_nm[:1], (cycles, PHASES)),
        kept=kept,
        waveform_rejections=rejections,
        peak_nm=np.resize(point.peak_nm, cycles) + rng.normal(0, 0.02, cycles),
        peak_kept=kept,
        peak_rejections=rejections,
    )


def no_load_result(**changes):
    """Return the result of a no-load run."""
    points = tuple(swing_point(f, 0.0, outlier=4 if f == 20 else None) for f in FREQUENCIES)
    result = Result(
        run=run_data(
            "20260302T085000Z_SSPB-NLI", "SSPB-NLI", "No-load inertia sweep, 1 Hz to 35 Hz"
        ),
        measurand="no-load torque of the rig",
        symbol="Tg",
        details=(
            TorqueDetails(loaded=points, fits=fits(points), raw_headline=Estimate(2.7, 0.012, inf)),
        ),
        checks=(Check("stroke", ok=True, text="the swing is that of the rig's eccentric"),),
    )
    return changed(result, **changes)


def report_input(result=None, **changes):
    """Return the input of a report, of a simulated rig unless `truth` says otherwise."""
    result = loaded_result() if result is None else result
    truth = {
        point.recording: {
            "starting_torque_nm": TRUTH_NM * point.load_n / 1000,
            "inertia_kgm2": J_KGM2,
        }
        for point in TorqueDetails.of(result).loaded
    }
    report = ReportInput(
        result=result,
        document={"format": "rigrunner: result/1"},
        truth=truth,
        provenance={
            "rigrunner": "0.1.0",
            "python": "3.11.2",
            "numpy": "2.1.0",
            "run.h5 sha256": "ab" * 32,
            "procedure": "SSPB-STT-1000 revision A, sha256 " + "cd" * 32,
        },
        events=(
            {
                "utc": "2026-03-02T09:15:02Z",
                "kind": "answer",
                "text": "Inner ring rotated 2-3 turns: yes (unattended)",
            },
            {"utc": "2026-03-02T09:20:11Z", "kind": "alarm", "text": "door opened for 2 s"},
        ),
    )
    return replace(report, **changes)


def deciding(decision, **changes):
    """Return the decision with its deciding limit only, changed."""
    return replace(decision, parts=(replace(decision.deciding, **changes),))
