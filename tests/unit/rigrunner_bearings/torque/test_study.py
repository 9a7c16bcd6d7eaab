"""A gauge study named by the station adds to the uncertainty, once in a mean."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from pydantic import ValidationError

from rigrunner_bearings.api.rig import NamedStudy
from rigrunner_bearings.api.torque import TorqueDetails
from unit.analysis.helpers_analysis import analysed, recording, run_of

FREQUENCIES = (2.0, 4.0, 6.0, 8.0, 10.0)
SCATTER = np.array([0.01, -0.01, 0.0, 0.02, -0.02, 0.0, 0.01, -0.01, 0.005, -0.005])
STUDY = {
    "source": "SSPB-GRR of October 2026",
    "between_mountings": {"u": "30 mN·m", "degrees_of_freedom": 60},
    "reproducibility": {"u": "40 mN·m", "degrees_of_freedom": 4.5},
}
LINES = {
    "scatter between mountings (SSPB-GRR of October 2026)": 0.03,
    "reproducibility (SSPB-GRR of October 2026)": 0.04,
}


def run(extra_nm=0.0, load_n=0.0, study=None, **changes):
    peaks = ((0.9 + 0.02 * f + 0.004 * f**2 + extra_nm, f) for f in FREQUENCIES)
    loaded = run_of(*(recording(p + SCATTER, f, load_n=load_n) for p, f in peaks), **changes)
    return replace(loaded, rig_keys={**loaded.rig_keys, "gauge_study": study})


def result(study):
    return analysed(run(0.7, 1000.0, study), run(run_id="run-0", procedure_id="SSPB-NLI"))


def test_study_is_in_every_point_and_once_in_mean():
    plain, named = result(None), result(STUDY)
    for before, after in zip(
        TorqueDetails.of(plain).compensations["paper_peak"].points,
        TorqueDetails.of(named).compensations["paper_peak"].points,
        strict=True,
    ):
        lines = {
            component.name: component for component in after.components if component.name in LINES
        }
        assert {name: component.u for name, component in lines.items()} == pytest.approx(LINES)
        assert all(component.common for component in lines.values())
        assert after.torque.value == before.torque.value
        assert after.torque.u == pytest.approx(np.hypot(before.torque.u, 0.05), rel=1e-9)
    assert named.headline.value == plain.headline.value
    assert named.headline.u == pytest.approx(np.hypot(plain.headline.u, 0.05), rel=1e-9)


def test_few_operators_give_few_degrees_of_freedom():
    """By Welch and Satterthwaite, with the two lines far above the scatter of all others."""
    headline = result(STUDY).headline
    expected = headline.u**4 / (0.03**4 / 60 + 0.04**4 / 4.5)
    assert headline.dof == pytest.approx(expected, rel=0.02)


def test_study_with_zero_u_adds_nothing():
    nothing = {"source": "x", "reproducibility": {"u": "0 N·m", "degrees_of_freedom": 2}}
    assert result(nothing).headline == result(None).headline


@pytest.mark.parametrize(
    "bad",
    [
        {"between_mountings": {"u": "30 mN·m", "degrees_of_freedom": 60}},
        {"source": "x", "reproducibility": {"u": "30 mN·m"}},
        {"source": "x", "reproducibility": {"u": "-1 mN·m", "degrees_of_freedom": 3}},
        {"source": "x", "reproducibility": {"u": "1 mN·m", "degrees_of_freedom": 0}},
    ],
)
def test_incomplete_study_is_refused(bad):
    with pytest.raises(ValidationError):
        NamedStudy.model_validate(bad)
