"""Settings of the simulated bench. `BenchParameters` explains the defaults."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from rigrunner.api import Angle, Force, Frequency, Length, Ratio, Settings, Torque
from rigrunner.api.settings import FrequencyRate, MomentOfInertia
from rigrunner_bearings.devices.rotation_tester_sim.parameters import BenchParameters
from rigrunner_bearings.devices.simulated.parameters import SensorParameters
from rigrunner_plugins.devices.fields import quantity


class BenchSensorSettings(Settings):
    """The measuring chain, without effects that a slow rotation does not show."""

    rate: Frequency = quantity("2 kHz", "samples per second and channel", gt=0)
    full_scale: Torque = quantity("2 N·m", "nominal torque of the transducer", gt=0)
    range: Torque = quantity("2.4 N·m", "largest torque that the converter can give", gt=0)
    bits: Annotated[int, Field(ge=1, le=32, description="resolution of the converter in bits")] = 16
    noise: Torque = quantity("2 mN·m", "standard deviation of white noise", ge=0)
    gain: Ratio = quantity("0.3 %", "limit of the gain error", ge=0, lt=1)
    offset: Torque = quantity("2 mN·m", "limit of the zero error", ge=0)
    drift: Torque = quantity("2 mN·m", "limit of the zero drift", ge=0)
    nonlinearity: Ratio = quantity("0.05 %", "limit of the error, of full scale", ge=0, lt=1)
    encoder_resolution: Angle = quantity("0.01 deg", "step of the encoder", ge=0)


class BenchBearingSettings(Settings):
    """Friction of the bearing without load, and what a load adds."""

    breakaway_torque: Torque = quantity(
        "0.3 N·m", "breakaway torque when run in, after 1 s of rest", gt=0
    )
    ageing: Torque = quantity("0.015 N·m", "increase for each tenfold longer rest", ge=0)
    kinetic_torque: Torque = quantity("0.22 N·m", "torque while it slides", gt=0)
    slip: Angle = quantity("0.05 deg", "travel in which the friction rises", gt=0)
    weakening: Angle = quantity("0.5 deg", "travel in which it falls from its peak", gt=0)
    friction_arm: Length = quantity(
        "0.5 mm", "kinetic torque that a load adds, divided by the load", ge=0
    )
    scatter: Ratio = quantity("3 %", "standard deviation between starts", ge=0, le=0.2)
    fresh_excess: Ratio = quantity("30 %", "excess of the friction of a new bearing", ge=0)
    running_in_turns: Annotated[
        float, Field(gt=0, description="turns in which 63 % of this excess disappears")
    ] = 0.5

    @model_validator(mode="after")
    def _has_a_peak(self) -> Self:
        if self.breakaway_torque <= self.kinetic_torque:
            raise ValueError("breakaway_torque must be above kinetic_torque")
        return self


class RotationTesterSettings(Settings):
    """A bench that turns a bearing slowly, and can start from rest while it records."""

    seed: Annotated[int, Field(ge=0, description="seed of the bench's random errors")] = 0
    simulate: Annotated[
        Literal["ready", "unplugged"], Field(description="unplugged: no answer")
    ] = "ready"
    max_frequency: Frequency = quantity("60 rpm", "fastest rotation that can be set", gt=0)
    frequency_rate: FrequencyRate = quantity("0.5 Hz/s", "rate of the rotation frequency", gt=0)
    max_load: Force = quantity("0 N", "largest load; 0 if the bench has none", ge=0)
    max_start_frequency: Frequency = quantity("5 rpm", "fastest start that can be set", gt=0)
    fixture_friction: Torque = quantity("4 mN·m", "friction of the bench's own supports", ge=0)
    inertia: MomentOfInertia = quantity("0.0005 kg·m²", "inertia behind the transducer", ge=0)
    bearing: BenchBearingSettings = Field(default_factory=BenchBearingSettings)
    sensors: BenchSensorSettings = Field(default_factory=BenchSensorSettings)

    def parameters(self) -> BenchParameters:
        """Return the bench in SI units."""
        bearing = self.bearing
        sensors = self.sensors
        return BenchParameters(
            breakaway_torque_nm=bearing.breakaway_torque,
            ageing_nm=bearing.ageing,
            kinetic_torque_nm=bearing.kinetic_torque,
            slip_rad=bearing.slip,
            weakening_rad=bearing.weakening,
            friction_arm_m=bearing.friction_arm,
            scatter=bearing.scatter,
            fresh_excess=bearing.fresh_excess,
            running_in_turns=bearing.running_in_turns,
            fixture_friction_nm=self.fixture_friction,
            inertia_kgm2=self.inertia,
            sensors=SensorParameters(
                sample_rate_hz=sensors.rate,
                full_scale_nm=sensors.full_scale,
                range_nm=sensors.range,
                adc_bits=sensors.bits,
                noise_nm=sensors.noise,
                spike_probability=0.0,
                gain_limit=sensors.gain,
                offset_limit_nm=sensors.offset,
                drift_limit_nm=sensors.drift,
                nonlinearity_limit=sensors.nonlinearity,
                encoder_resolution_rad=sensors.encoder_resolution,
            ),
        )
