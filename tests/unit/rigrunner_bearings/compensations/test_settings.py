import subprocess
import sys

import pytest
from pydantic import ValidationError

from rigrunner_bearings.compensations.settings import EnergySettings, TemplateInverseSettings


def test_reads_quantities_with_units():
    settings = TemplateInverseSettings.model_validate(
        {"window": "1 deg", "inertia_mismatch": "0.2 %", "frequency_match": "0.5 %"}
    )
    assert settings.window == pytest.approx(0.0174533, rel=1e-5)
    assert settings.inertia_mismatch == pytest.approx(0.002)
    assert settings.window == pytest.approx(TemplateInverseSettings().window)


@pytest.mark.parametrize(
    ("key", "value"),
    [("window", 1.0), ("frequency_match", "10 %"), ("inertia_mismatch", "-1 %"), ("fc", "1 Hz")],
)
def test_refuses_invalid_values(key, value):
    with pytest.raises(ValidationError):
        TemplateInverseSettings.model_validate({key: value})


def test_energy_has_no_window():
    with pytest.raises(ValidationError):
        EnergySettings.model_validate({"window": "1 deg"})


def test_settings_load_without_numpy():
    code = (
        "import sys, rigrunner_bearings.compensations.settings; assert 'numpy' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
