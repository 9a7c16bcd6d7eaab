"""A fake NI-DAQmx driver below the real nidaqmx library: the functions of its C API.

The library's own Python code runs; only its calls of the driver end here. Attributes and
constants are known by their numbers in NI's header NIDAQmx.h.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from nidaqmx._base_interpreter import BaseInterpreter
from nidaqmx.errors import DaqError, DaqReadError

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from rigrunner.clock import SimulatedClock

PRODUCT_TYPE, SERIAL_NUM, IS_SIMULATED = 0x0631, 0x0632, 0x22CA
SAMP_CLK_RATE = 0x1344
MAJOR, MINOR, UPDATE = 0x1272, 0x1923, 0x2F22
TASK_CHANNELS, TASK_NAME = 0x1273, 0x1276
CHAN_TYPE, READ_CHANNELS, NUM_CHANS = 0x187F, 0x1823, 0x217B
LINES_PER_CHAN = 0x217C
WRITE_NUM_CHANS, WRITE_LINES_PER_CHAN = 0x217E, 0x217F
FILTER_DELAY, LOWPASS_CUTOFF, REMOVE_FILTER_DELAY = 0x2FED, 0x1803, 0x2FBD
ANALOG_INPUT, DIGITAL_OUTPUT, ANALOG_OUTPUT, COUNTER_INPUT = 10100, 10153, 10102, 10131

_NAMED_BY = "name_to_assign_to_"


class _Task:
    """One task: its channels in order, and what was configured."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.channels: list[str] = []
        self.kind = 0
        self.rate_hz = 0.0
        self.samples_read = 0
        self.value = 0.0
        self.is_running = False


class FakeDriver:
    """The functions of the driver; `calls` are those that the library called."""

    def __init__(
        self,
        clock: SimulatedClock,
        signals: Mapping[str, Callable[[np.ndarray], np.ndarray]],
        *,
        coerced_hz: float | None = None,
        filters: bool = True,
        fails: Mapping[str, int] | None = None,
        product: str = "NI 9237",
    ) -> None:
        self.clock = clock
        self.signals = signals
        self.coerced_hz = coerced_hz
        self.has_filters = filters
        self.fails = dict(fails or {})
        self.product = product
        self.calls: list[tuple[str, tuple]] = []
        self.tasks: list[_Task] = []
        self.outputs: dict[str, float] = {}

    def called(self, function: str) -> list[tuple]:
        return [arguments for name, arguments in self.calls if name == function]

    @property
    def open_tasks(self) -> int:
        return len(self.called("create_task")) - len(self.called("clear_task"))

    def interpreter(self) -> BaseInterpreter:
        """Return the interpreter that the library takes for the driver."""

        def function_named(name: str):
            implementation = getattr(self, f"_{name}", None)

            def function(_self, *arguments):
                self.calls.append((name, arguments))
                if name in self.fails:
                    code = self.fails[name]
                    raise (
                        DaqReadError("", code, 0) if name.startswith("read") else DaqError("", code)
                    )
                return implementation(*arguments) if implementation else None

            return function

        members = {name: function_named(name) for name in BaseInterpreter.__abstractmethods__}
        members["__slots__"] = ()
        return type("FakeInterpreter", (BaseInterpreter,), members)()

    def _create_task(self, name: str):
        self.tasks.append(_Task(name or f"_unnamedTask<{len(self.tasks)}>"))
        return self.tasks[-1], True

    def _hash_task_handle(self, task):
        return id(task)

    def _start_task(self, task):
        task.is_running = True

    def _add(self, kind: int, task, _source, name, *_rest):
        task.kind = kind
        task.channels.append(name)

    def _create_ai_voltage_chan(self, *arguments):
        self._add(ANALOG_INPUT, *arguments)

    _create_ai_torque_bridge_two_point_lin_chan = _create_ai_voltage_chan
    _create_ai_torque_bridge_table_chan = _create_ai_voltage_chan

    def _create_ci_ang_encoder_chan(self, *arguments):
        self._add(COUNTER_INPUT, *arguments)

    def _create_ao_voltage_chan(self, *arguments):
        self._add(ANALOG_OUTPUT, *arguments)

    def _create_do_chan(self, *arguments):
        self._add(DIGITAL_OUTPUT, *arguments)

    def _cfg_samp_clk_timing(self, task, rate, *_):
        task.rate_hz = self.coerced_hz or rate

    def _get_timing_attribute_double(self, task, attribute):
        assert attribute == SAMP_CLK_RATE
        return task.rate_hz

    def _get_device_attribute_string(self, _device, attribute):
        return {PRODUCT_TYPE: self.product}[attribute]

    def _get_device_attribute_uint32(self, _device, attribute):
        return {SERIAL_NUM: 0x1A2B3C4}[attribute]

    def _get_device_attribute_bool(self, _device, attribute):
        return {IS_SIMULATED: False}[attribute]

    def _get_system_info_attribute_uint32(self, attribute):
        return {MAJOR: 26, MINOR: 0, UPDATE: 0}[attribute]

    def _get_task_attribute_string(self, task, attribute):
        return {TASK_CHANNELS: ", ".join(task.channels), TASK_NAME: task.name}[attribute]

    def _get_chan_attribute_int32(self, task, _channel, attribute):
        return {CHAN_TYPE: task.kind}[attribute]

    def _get_chan_attribute_double(self, _task, _channel, attribute):
        if not self.has_filters:
            raise DaqError("", -200452)  # DAQmxErrorAttrNotSupported
        return {FILTER_DELAY: 0.0031, LOWPASS_CUTOFF: 4530.0}[attribute]

    def _get_read_attribute_string(self, task, attribute, _size_hint=0):
        return {READ_CHANNELS: ", ".join(task.channels)}[attribute]

    def _get_read_attribute_uint32(self, task, attribute):
        return {NUM_CHANS: len(task.channels), LINES_PER_CHAN: 1}[attribute]

    def _get_write_attribute_uint32(self, task, attribute):
        return {WRITE_NUM_CHANS: len(task.channels), WRITE_LINES_PER_CHAN: 1}[attribute]

    def _read_analog_f64(self, task, samples, _timeout, _fill, array):
        array.reshape(len(task.channels), samples)[:] = self._sampled(task, samples)
        self.clock.sleep(samples / task.rate_hz)
        return array, samples

    def _read_counter_f64_ex(self, task, samples, _timeout, _fill, array):
        array[:] = self._sampled(task, samples)[0]
        return array, samples

    def _sampled(self, task, samples):
        assert task.is_running
        time_s = (task.samples_read + np.arange(samples)) / task.rate_hz
        task.samples_read += samples
        return np.array([self.signals[name](time_s) for name in task.channels])

    def _read_digital_lines(self, task, _samples, _timeout, _fill, array):
        array[:] = bool(self.outputs.get(task.channels[0], 0.0))
        return array, 1, 1

    def _write_analog_f64(self, task, _samples, _start, _timeout, _layout, array):
        self.outputs[task.channels[0]] = float(array.ravel()[0])
        return 1

    def _write_digital_lines(self, task, _samples, _start, _timeout, _layout, array):
        self.outputs[task.channels[0]] = float(array.ravel()[0])
        return 1
