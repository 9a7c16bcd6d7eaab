"""Settings that every simulated tester has: its swing, its drives, its measuring chain."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from rigrunner.api import Angle, Duration, Force, Frequency, Length, Ratio, Settings, Torque
from rigrunner.api.settings import AngularVelocity, ForceRate, FrequencyRate
from rigrunner_bearings.devices.simulated.parameters import SensorParameters
from rigrunner_plugins.devices.fields import quantity


class SensorSettings(Settings):
    """The measuring chain with its errors."""

    rate: Frequency = quantity("10 kHz", "samples per second and channel", gt=0)
    full_scale: Torque = quantity("10 N·m", "nominal torque of the transducer", gt=0)
    range: Torque = quantity("12 N·m", "largest torque that the converter can give", gt=0)
    bits: Annotated[int, Field(ge=1, le=32, description="resolution of the converter in bits")] = 16
    noise: Torque = quantity("0.02 N·m", "standard deviation of white noise", ge=0)
    spike_probability: Ratio = quantity("0.002 %", "probability of a spike, per sample", ge=0, le=1)
    spike: Torque = quantity("5 N·m", "largest spike of either sign", ge=0)
    low_pass: Frequency = quantity("1 kHz", "corner of the second-order Butterworth filter", gt=0)
    gain: Ratio = quantity("0.3 %", "limit of the gain error", ge=0, lt=1)
    offset: Torque = quantity("0.02 N·m", "limit of the zero error", ge=0)
    drift: Torque = quantity("0.02 N·m", "limit of the zero drift", ge=0)
    drift_time: Duration = quantity("10 min", "time in which 63 % of the drift occurs", gt=0)
    nonlinearity: Ratio = quantity("0.05 %", "limit of the error, of full scale", ge=0, lt=1)
    torque_delay: Duration = quantity("0 s", "delay of the torque relative to the angle", ge=0)
    encoder_resolution: Angle = quantity("0.01 deg", "step of the encoder", ge=0)
    encoder_noise: Angle = quantity("0 deg", "standard deviation, such as 0.003 deg", ge=0)
    tacho_noise: AngularVelocity = quantity("0.02 rad/s", "standard deviation", ge=0)
    index_phase: Angle = quantity("0 deg", "crank phase at which the index pulse rises")


class TesterSettings(Settings):
    """What any simulated swing tester can be set to."""

    seed: Annotated[int, Field(ge=0, description="seed of the rig's random errors")] = 0
    simulate: Annotated[
        Literal["ready", "unplugged"], Field(description="unplugged: no answer")
    ] = "ready"
    eccentric: Length = quantity("2 mm", "radius e of the crank", gt=0)
    centre_distance: Length = quantity(
        "45 mm", "distance L between the axes of crank and swing", gt=0
    )
    max_frequency: Frequency = quantity("35 Hz", "highest frequency that can be set", gt=0)
    frequency_rate: FrequencyRate = quantity("10 Hz/s", "rate of the frequency", gt=0)
    max_load: Force = quantity("3 kN", "highest load that can be set", gt=0)
    load_rate: ForceRate = quantity("500 N/s", "rate of the load", gt=0)
    speed_jitter: Ratio = quantity(
        "0 %", "standard deviation of each turn's speed, such as 0.05 %", ge=0, le=0.05
    )
    frequency_error: Ratio = quantity(
        "0 %", "relative excess of the true frequency over the set-point", gt=-1, lt=1
    )
    sensors: SensorSettings = Field(default_factory=SensorSettings)

    @model_validator(mode="after")
    def _the_bar_swings(self) -> Self:
        if self.eccentric >= self.centre_distance:
            raise ValueError("the eccentric must be smaller than the centre distance")
        return self

    @property
    def eccentric_ratio(self) -> float:
        """Lambda = e / L."""
        return self.eccentric / self.centre_distance

    def sensor_parameters(self) -> SensorParameters:
        """Return the measuring chain in SI units."""
        sensors = self.sensors
        return SensorParameters(
            sample_rate_hz=sensors.rate,
            full_scale_nm=sensors.full_scale,
            range_nm=sensors.range,
            adc_bits=sensors.bits,
            noise_nm=sensors.noise,
            spike_probability=sensors.spike_probability,
            spike_nm=sensors.spike,
            low_pass_hz=sensors.low_pass,
            gain_limit=sensors.gain,
            offset_limit_nm=sensors.offset,
            drift_limit_nm=sensors.drift,
            drift_time_s=sensors.drift_time,
            nonlinearity_limit=sensors.nonlinearity,
            torque_delay_s=sensors.torque_delay,
            encoder_resolution_rad=sensors.encoder_resolution,
            encoder_noise_rad=sensors.encoder_noise,
            tacho_noise_rad_s=sensors.tacho_noise,
            index_phase_rad=sensors.index_phase,
            speed_jitter=self.speed_jitter,
            frequency_error=self.frequency_error,
        )
