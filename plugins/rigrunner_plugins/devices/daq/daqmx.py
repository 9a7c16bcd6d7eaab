"""The only place that touches the nidaqmx library: tasks with one sample clock, and outputs."""

from __future__ import annotations

from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from rigrunner.api import (
    DeviceError,
    DeviceLostError,
    DeviceNotFoundError,
    DeviceRejectedError,
    DeviceTimeoutError,
)
from rigrunner_plugins.devices.daq.settings import (
    DigitalOutput,
    EncoderChannel,
    TorqueChannel,
    VoltageOutput,
)
from rigrunner_plugins.devices.extras import missing_package

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from rigrunner.api import Array
    from rigrunner_plugins.devices.daq.settings import DaqSettings, VoltageChannel

TERMINALS = {
    "default": "DEFAULT",
    "differential": "DIFF",
    "rse": "RSE",
    "nrse": "NRSE",
    "pseudo_differential": "PSEUDO_DIFF",
}
PHASES = {
    "high_high": "AHIGH_BHIGH",
    "high_low": "AHIGH_BLOW",
    "low_high": "ALOW_BHIGH",
    "low_low": "ALOW_BLOW",
}

NOT_THERE = {
    "INVALID_DEVICE_ID",
    "INVALID_DEVICE_ID_IN_LIST",
    "PHYSICAL_CHAN_DOES_NOT_EXIST",
    "DEVICE_REMOVED",
}
"""Names of the library's error codes."""
OVERRUN = {
    "SAMPLES_NO_LONGER_AVAILABLE",
    "ADC_OVERRUN",
    "AI_OVERRUN",
    "CI_OVERRUN",
}
LATE = {"SAMPLES_NOT_YET_AVAILABLE", "TIMEOUT_EXCEEDED", "WAIT_UNTIL_DONE_DOES_NOT_INDICATE_DONE"}
TAKEN = {"RESOURCE_ALREADY_RESERVED", "PAL_RESOURCE_RESERVED"}
NO_DRIVER = (
    "install NI-DAQmx from ni.com for your system, restart, and look whether NI MAX, or"
    " 'nilsdev' on Linux, shows the device"
)


@dataclass(frozen=True)
class Facts:
    """Which device it is."""

    model: str
    serial: str
    simulated: bool
    driver: str


def library() -> Any:
    """Return the module nidaqmx; raise MissingPackageError where it is not installed."""
    try:
        import nidaqmx.constants  # noqa: PLC0415  (an optional package)
        import nidaqmx.stream_readers  # noqa: PLC0415  (an optional package)
        import nidaqmx.system  # noqa: PLC0415  (an optional package)
    except ImportError as error:
        raise missing_package("nidaqmx", "daq") from error
    return nidaqmx


def facts(device: str) -> Facts:
    """Return who a device is; raise a DeviceError where driver or device are not there."""
    ni = library()
    with daq_errors(f"look for {device}"):
        version = ni.system.System.local().driver_version
        ni_device = ni.system.Device(device)
        return Facts(
            model=ni_device.product_type,
            serial=f"{ni_device.serial_num:X}",
            simulated=bool(ni_device.is_simulated),
            driver=".".join(str(part) for part in version),
        )


class Acquisition:
    """All channels of a device, sampled at the same edges until it is closed.

    The analogue inputs are one task; each counter is a task of its own, that follows the analogue
    task's sample clock and is started before it.
    """

    def __init__(self, settings: DaqSettings) -> None:
        self._ni = library()
        self._settings = settings
        self._open = ExitStack()
        self._analog: list[str] = []
        self._encoders: dict[str, Any] = {}
        self._task: Any = None
        try:
            with daq_errors("set up the channels"):
                self._set_up()
        except BaseException:
            self.close()
            raise

    @property
    def rate_hz(self) -> float:
        """The rate that the device really samples at."""
        task = self._task or next(iter(self._encoders.values()))
        with daq_errors("set up the sample clock"):
            return float(task.timing.samp_clk_rate)

    def filters(self) -> dict[str, tuple[float, str]]:
        """Return the delay and the corner of each analogue channel's filter, if it reports them.

        By '<channel>_filter_delay' in s and '<channel>_filter_corner' in Hz.
        """
        conditions: dict[str, tuple[float, str]] = {}
        units = self._ni.constants.DigitalWidthUnits.SECONDS
        for name in self._analog:
            channel = self._task.ai_channels[name]
            with suppress(DeviceError), daq_errors("read the filter"):  # many devices have none
                channel.ai_filter_delay_units = units
                conditions[f"{name}_filter_delay"] = (float(channel.ai_filter_delay), "s")
            with suppress(DeviceError), daq_errors("read the filter"):
                conditions[f"{name}_filter_corner"] = (float(channel.ai_lowpass_cutoff_freq), "Hz")
        return conditions

    def start(self) -> None:
        """Start the counters, then the analogue inputs whose clock they follow."""
        with daq_errors("start"):
            for task in self._encoders.values():
                task.start()
            if self._task is not None:
                self._task.start()

    def read(self, samples: int, timeout_s: float) -> dict[str, Array]:
        """Return the next samples of each channel, shape (n,): volts, N·m or rad."""
        readers = self._ni.stream_readers
        values: dict[str, Array] = {}
        with daq_errors("read", running=True):
            if self._task is not None:
                block = np.empty((len(self._analog), samples), dtype=np.float64)
                reader = readers.AnalogMultiChannelReader(self._task.in_stream)
                reader.read_many_sample(block, samples, timeout_s)
                values |= dict(zip(self._analog, block, strict=True))
            for name, task in self._encoders.items():
                angles = np.empty(samples, dtype=np.float64)
                counter = readers.CounterReader(task.in_stream)
                counter.read_many_sample_double(angles, samples, timeout_s)
                values[name] = angles
        return values

    def close(self) -> None:
        """Stop and clear the tasks, whatever state they are in."""
        with suppress(DeviceError), daq_errors("close", running=True):  # a device that is gone is
            self._open.close()

    def _set_up(self) -> None:
        for name, channel in self._settings.channels.items():
            if isinstance(channel, EncoderChannel):
                self._encoders[name] = self._new_task()
                self._add_encoder(self._encoders[name], name, channel)
            else:
                self._task = self._task or self._new_task()
                if isinstance(channel, TorqueChannel):
                    ni_channel = self._add_torque(self._task, name, channel)
                else:
                    ni_channel = self._add_voltage(self._task, name, channel)
                self._analog.append(name)
                if self._settings.remove_filter_delay:
                    ni_channel.ai_remove_filter_delay = True
        continuous = {
            "sample_mode": self._ni.constants.AcquisitionType.CONTINUOUS,
            "samps_per_chan": round(self._settings.rate * self._settings.buffer),
        }
        if self._task is not None:
            # An empty name is the device's own sample clock.
            clock = self._settings.sample_clock or ""
            self._task.timing.cfg_samp_clk_timing(self._settings.rate, clock, **continuous)
        for task in self._encoders.values():
            clock = self._settings.counter_clock
            task.timing.cfg_samp_clk_timing(self._settings.rate, clock, **continuous)

    def _new_task(self) -> Any:
        return self._open.enter_context(self._ni.Task())

    def _add_voltage(self, task: Any, name: str, channel: VoltageChannel) -> Any:
        terminal = self._ni.constants.TerminalConfiguration[TERMINALS[channel.terminal]]
        return task.ai_channels.add_ai_voltage_chan(
            channel.source,
            name_to_assign_to_channel=name,
            terminal_config=terminal,
            min_val=channel.low,
            max_val=channel.high,
        )

    def _add_torque(self, task: Any, name: str, channel: TorqueChannel) -> Any:
        constants = self._ni.constants
        ratios, torques = ([*column] for column in zip(*channel.table, strict=True))
        arguments = {
            "name_to_assign_to_channel": name,
            "min_val": -channel.range,
            "max_val": channel.range,
            "units": constants.TorqueUnits.NEWTON_METERS,
            "bridge_config": constants.BridgeConfiguration[f"{channel.bridge.upper()}_BRIDGE"],
            "voltage_excit_source": constants.ExcitationSource[channel.excited.upper()],
            "voltage_excit_val": channel.excitation,
            "nominal_bridge_resistance": channel.resistance,
            "electrical_units": constants.BridgeElectricalUnits.MILLIVOLTS_PER_VOLT,
            "physical_units": constants.BridgePhysicalUnits.NEWTON_METERS,
        }
        if len(ratios) > 2:  # noqa: PLR2004  (a line has two points)
            return task.ai_channels.add_ai_torque_bridge_table_chan(
                channel.source, electrical_vals=ratios, physical_vals=torques, **arguments
            )
        return task.ai_channels.add_ai_torque_bridge_two_point_lin_chan(
            channel.source,
            first_electrical_val=ratios[0],
            second_electrical_val=ratios[1],
            first_physical_val=torques[0],
            second_physical_val=torques[1],
            **arguments,
        )

    def _add_encoder(self, task: Any, name: str, channel: EncoderChannel) -> None:
        constants = self._ni.constants
        task.ci_channels.add_ci_ang_encoder_chan(
            channel.source,
            name_to_assign_to_channel=name,
            decoding_type=constants.EncoderType[channel.decoding.upper().replace("X", "X_")],
            zidx_enable=channel.index,
            zidx_val=channel.index_angle,
            zidx_phase=constants.EncoderZIndexPhase[PHASES[channel.index_when]],
            units=constants.AngleUnits.RADIANS,
            pulses_per_rev=channel.pulses,
            initial_angle=channel.start,
        )


class Outputs:
    """The outputs of a device: each keeps its value as long as its task is open."""

    def __init__(self, drives: Mapping[str, VoltageOutput | DigitalOutput]) -> None:
        self._ni = library()
        self._drives = drives
        self._open = ExitStack()
        self._tasks: dict[str, Any] = {}
        try:
            with daq_errors("set up the outputs"):
                for name, drive in drives.items():
                    self._tasks[name] = self._new(name, drive)
        except BaseException:
            self.close()
            raise

    def write(self, name: str, number: float) -> None:
        """Give out a voltage in V, or a line's level."""
        level = bool(number) if isinstance(self._drives[name], DigitalOutput) else float(number)
        with daq_errors(f"write {name}", running=True):
            self._tasks[name].write(level, auto_start=True)

    def read_line(self, name: str) -> float:
        """Return the level that a line has, as the device reads it."""
        with daq_errors(f"read {name}", running=True):
            return float(bool(self._tasks[name].read()))

    def close(self) -> None:
        """Clear the tasks; the device defines the values of its outputs after that."""
        with suppress(DeviceError), daq_errors("close", running=True):  # a device that is gone is
            self._open.close()

    def _new(self, name: str, drive: VoltageOutput | DigitalOutput) -> Any:
        task = self._open.enter_context(self._ni.Task())
        if isinstance(drive, DigitalOutput):
            task.do_channels.add_do_chan(drive.source, name_to_assign_to_lines=name)
        else:
            # A negative scale swaps the ends of the range.
            ends = sorted(drive.from_si(limit.si) for limit in (drive.min, drive.max))
            task.ao_channels.add_ao_voltage_chan(
                drive.source, name_to_assign_to_channel=name, min_val=ends[0], max_val=ends[1]
            )
        return task


@contextmanager
def daq_errors(what: str, *, running: bool = False) -> Iterator[None]:
    """Raise a DeviceError for what the library raises; `running`: a device that was there."""
    from nidaqmx import errors  # noqa: PLC0415  (an optional package)

    try:
        yield
    except (errors.DaqNotFoundError, errors.DaqNotSupportedError) as error:
        raise DeviceNotFoundError(f"{what}: {_summary(error)}", hint=NO_DRIVER) from error
    except errors.DaqError as error:
        raise _coded_error(what, error.error_type.name, _summary(error), running=running) from error
    except errors.Error as error:
        raise DeviceRejectedError(f"{what}: {_summary(error)}") from error


def _coded_error(what: str, code: str, words: str, *, running: bool) -> DeviceError:
    if code in OVERRUN:
        return DeviceLostError(
            f"{what}: samples were lost, they came faster than they were read: {words}",
            hint="record at a lower rate, use a longer buffer, or reduce the load of the computer",
        )
    if code in NOT_THERE:
        kind = DeviceLostError if running else DeviceNotFoundError
        return kind(f"{what}: {words}", hint="is it plugged in, and has it this name in NI MAX?")
    if code in LATE:
        hint = "does the sample clock run? see sample_clock, and the chassis of the module"
        return DeviceTimeoutError(f"{what}: {words}", hint=hint)
    if code in TAKEN:
        return DeviceRejectedError(f"{what}: {words}", hint="close the program that uses it")
    return DeviceRejectedError(f"{what}: {words}")


def _summary(error: Exception) -> str:
    """Return the first line of the driver's message; paragraphs of properties follow it."""
    return str(error).strip().partition("\n")[0].rstrip(".")
