"""PyMeasure's real classes as instruments of a station."""

from __future__ import annotations

from pathlib import Path

import pytest

from rigrunner.api.devices import Approaching, Device, Identity, Readable
from rigrunner.api.errors import (
    DeviceLostError,
    DeviceNotFoundError,
    DeviceRejectedError,
    DeviceTimeoutError,
    PluginError,
)
from rigrunner.rig import Rig
from rigrunner_plugins.devices.pymeasure.binding import instrument_class, unit_in_description
from unit.rigrunner_plugins.devices.helpers_instruments import REGISTRY, instrument, merged
from unit.rigrunner_plugins.devices.helpers_peers import HANG_UP, SILENCE, Lines, SocketPeer, peer

HERE = Path(__file__).parent
SIMULATED = {"backend": "instruments.yaml@sim", "simulated": "yes"}
TERMINATED = {"read_termination": "\n", "write_termination": "\n"}
KEITHLEY = {
    "instrument": "pymeasure.instruments.keithley.Keithley2000",
    "resource": "GPIB0::16::INSTR",
    "connection": TERMINATED,
    "expect": "KEITHLEY.*MODEL 2000.*",
    # a bridge of 2 mV/V at 10 N·m, fed with 1 V: 5 N·m per mV, which is 5000 N·m per volt
    "channels": {"torque": {"property": "voltage", "unit": "N·m", "scale": 5000}},
}
FREQUENCY = {"property": "frequency", "unit": "Hz", "min": "1 Hz", "max": "20 kHz", "safe": "1 Hz"}
AGILENT = {
    "instrument": "pymeasure.instruments.agilent.Agilent33220A",
    "resource": "GPIB0::10::INSTR",
    "connection": TERMINATED,
    "check_errors": "yes",
    "drives": {"frequency": FREQUENCY},
}
STANFORD = {
    "instrument": "pymeasure.instruments.srs.SR830",
    "resource": "GPIB0::8::INSTR",
    "connection": TERMINATED,
    "channels": {"signal": {"property": "x", "unit": "mV", "scale": 1000}},
    "drives": {"reference": {**FREQUENCY, "min": "0.01 Hz"}},
}
LAKESHORE = {
    "instrument": "pymeasure.instruments.lakeshore.LakeShore211",
    "resource": "GPIB0::12::INSTR",
    "connection": TERMINATED,
    "expect": "LSCI,MODEL211S,.*",
    "channels": {"bearing": {"property": "temperature_celsius", "unit": "°C"}},
}


def simulated(settings, **changes):
    return instrument("pymeasure", merged({**settings, **SIMULATED}, **changes), folder=HERE)


def test_device_has_its_abilities():
    device = simulated(KEITHLEY)
    assert all(isinstance(device, ability) for ability in (Device, Readable, Approaching))


class TestFourMakers:
    def test_keithley_multimeter_reads_torque(self):
        device = simulated(KEITHLEY)
        assert device.connect(2.0) == Identity(
            "KEITHLEY INSTRUMENTS INC.", "MODEL 2000", "0612345", "A02", simulated=True
        )
        assert device.read(["torque"]) == {"torque": pytest.approx(7.5)}  # 1.5 mV * 5 N·m/mV
        device.close()

    def test_agilent_generator_is_set_and_read_back(self):
        device = simulated(AGILENT)
        assert device.connect(2.0) == Identity("agilent", "Agilent33220A", "", simulated=True)
        device.set("frequency", 12.5)
        assert device.read_back("frequency") == 12.5
        with pytest.raises(DeviceRejectedError, match="1 to 20000 Hz"):
            device.set("frequency", 30e3)
        assert device.make_safe() == {"frequency": 1.0}
        device.close()

    def test_stanford_amplifier_is_set_and_read(self):
        device = simulated(STANFORD)
        device.connect(2.0)
        device.set("reference", 35.0)
        assert device.read(["signal"]) == {"signal": pytest.approx(0.0125)}
        device.close()

    def test_lake_shore_thermometer_reads_kelvin(self):
        device = simulated(LAKESHORE)
        device.connect(2.0)
        assert device.read(["bearing"]) == {"bearing": pytest.approx(296.65)}
        device.close()


class TestSocket:
    """PyMeasure over pyvisa-py, to a peer that hangs up."""

    @pytest.fixture
    def answers(self):
        return {
            "*IDN?": b"KEITHLEY INSTRUMENTS INC.,MODEL 2000,0612345,A02\n",
            ":READ?": b"+1.500000E-03\n",
        }

    @pytest.fixture
    def bench(self, answers):
        with peer(SocketPeer, Lines(lambda line: answers.get(line, SILENCE))) as server:
            yield server

    @pytest.fixture
    def device(self, bench):
        device = instrument(
            "pymeasure", merged(KEITHLEY, resource=bench.resource, timeout="1500 ms")
        )
        yield device
        device.close()

    def test_device_connects_and_reads(self, device):
        assert device.connect(2.0).model == "MODEL 2000"
        assert device.read(["torque"]) == {"torque": pytest.approx(7.5)}

    def test_another_instrument_is_refused(self, device, answers):
        answers["*IDN?"] = b"OTHER,PSU,1,2\n"
        with pytest.raises(DeviceNotFoundError, match=r"'OTHER,PSU,1,2'.*does not fit 'KEITHLEY"):
            device.connect(2.0)

    def test_unreachable_instrument_is_reported(self, device, bench):
        bench.close()
        with pytest.raises(DeviceNotFoundError, match="no answer from"):
            device.connect(2.0)

    def test_silent_instrument_times_out_and_recovers(self, device, answers):
        device.connect(2.0)
        answers[":READ?"] = SILENCE
        with pytest.raises(DeviceTimeoutError, match=r"no answer to 'get voltage' within 1\.5 s"):
            device.read(["torque"])
        answers[":READ?"] = b"+2.0E-03\n"
        assert device.read(["torque"]) == {"torque": pytest.approx(10.0)}

    def test_setup_is_repeated_after_a_lost_connection(self, bench, answers):
        settings = merged(KEITHLEY, resource=bench.resource, timeout="1500 ms")
        device = instrument("pymeasure", merged(settings, setup={"voltage_nplc": 1}))
        device.connect(2.0)
        answers[":READ?"] = HANG_UP
        with pytest.raises(DeviceLostError):
            device.read(["torque"])
        answers[":READ?"] = b"+2.0E-03\n"
        device.read(["torque"])
        assert bench._talk.heard[-3:] == ["*IDN?", ":SENS:VOLT:NPLC 1", ":READ?"]
        device.close()

    def test_lost_connection_is_reported(self, device, answers, bench):
        device.connect(2.0)
        answers[":READ?"] = HANG_UP
        with pytest.raises(
            DeviceLostError, match="'get voltage': the other end closed the connection"
        ):
            device.read(["torque"])
        bench.close()
        with pytest.raises(DeviceLostError, match="no answer from"):
            device.read(["torque"])

    @pytest.mark.parametrize(
        ("answer", "message"),
        [
            (b"OVERFLOW\n", "the property voltage gives 'OVERFLOW', which is not a number"),
            (b"+9.90000000E+37\n", r"gives 9\.9e\+37: overload"),
            (b"1,2,3\n", "gives 3 values.*`item`"),
        ],
    )
    def test_answer_that_is_not_a_number_is_refused(self, device, answers, answer, message):
        device.connect(2.0)
        answers[":READ?"] = answer
        with pytest.raises(DeviceRejectedError, match=message):
            device.read(["torque"])

    def test_item_of_several_numbers_is_read(self, bench, answers):
        answers[":READ?"] = b"1,2,3\n"
        channel = {"property": "voltage", "unit": "V", "item": 2}
        settings = merged(KEITHLEY, resource=bench.resource, channels={"u": channel})
        device = instrument("pymeasure", settings)
        device.connect(2.0)
        assert device.read(["u"]) == {"u": 2.0}
        device.close()

    def test_setup_and_calls_are_sent_on_connect(self, bench):
        settings = merged(
            KEITHLEY,
            resource=bench.resource,
            setup={"voltage_nplc": 1},
            calls=["measure_voltage"],
            safe_calls=["beep_not"],
        )
        with pytest.raises(PluginError, match=r"no method 'beep_not' that needs no arg"):
            instrument("pymeasure", settings)
        device = instrument("pymeasure", merged(settings, safe_calls=["shutdown"]))
        device.connect(2.0)
        ranged = ":SENS:VOLT:RANG:AUTO 0;:SENS:VOLT:RANG 1"
        assert bench._talk.last(ranged) == ranged
        assert bench._talk.heard[:-1] == ["*IDN?", ":SENS:VOLT:NPLC 1", ":CONF:VOLT:DC"]
        assert device.make_safe() == {}
        assert device._instrument.isShutdown
        device.close()


def test_set_point_silently_clipped_by_pymeasure_is_detected():
    """SR830's class silently limits its frequency to 102 kHz; the read-back shows it."""
    wide = {**FREQUENCY, "max": "200 kHz", "tolerance": "1 Hz", "settle": "100 ms"}
    device = simulated(STANFORD, drives={"reference": wide})
    device.connect(2.0)
    with pytest.raises(DeviceTimeoutError, match="reference reads back 102000 Hz"):
        device.set("reference", 150e3)
    device.close()


def test_value_that_a_validator_refuses_is_reported():
    device = simulated(KEITHLEY, setup={"voltage_nplc": 1, "mode": "torque"})
    with pytest.raises(DeviceRejectedError, match=r"PyMeasure failed to set mode torque: \w+Error"):
        device.connect(2.0)


def test_instrument_errors_are_reported():
    errors = ['-222,"Data out of range"', '+0,"No error"']

    def answer(line):
        if line == "SYST:ERR?":
            return f"{errors.pop(0)}\n".encode()
        return SILENCE

    with peer(SocketPeer, Lines(answer)) as bench:
        device = instrument("pymeasure", merged(AGILENT, resource=bench.resource))
        device.connect(2.0)
        with pytest.raises(DeviceRejectedError, match=r"frequency = 12\.5.*Data out of range"):
            device.begin("frequency", 12.5)
        device.close()


class TestInARig:
    """After a lost connection the generator is at its safe value, or is reported unsafe."""

    @pytest.fixture
    def generator(self):
        state = {"FREQ": "50", "heard": 0}

        def answer(line):
            state["heard"] += 1
            if state["heard"] == state.get("hangs up at"):
                return HANG_UP
            if line.startswith("FREQ "):
                state["FREQ"] = line.split()[1]
                return SILENCE
            answers = {"FREQ?": state["FREQ"], "SYST:ERR?": '+0,"No error"'}
            return f"{answers[line]}\n".encode() if line in answers else SILENCE

        return state, Lines(answer)

    @pytest.fixture
    def bench(self, generator):
        with peer(SocketPeer, generator[1]) as server:
            yield server

    @pytest.fixture
    def rig(self, bench):
        settings = merged(AGILENT, resource=bench.resource, timeout="1500 ms")
        device = instrument("pymeasure", settings)
        rig = Rig({"generator": device}, device.clock)
        rig.connect()
        yield rig
        rig.close()

    def test_generator_is_made_safe_after_a_lost_connection(self, rig, generator):
        state, _ = generator
        assert rig.set("generator", "frequency", 12.5) == 12.5
        state["hangs up at"] = state["heard"] + 2  # at the query for errors
        with pytest.raises(DeviceLostError, match=r"^generator: .*check errors"):
            rig.set("generator", "frequency", 20.0)
        (report,) = rig.make_safe()
        assert report.safe, report.problems
        assert float(state["FREQ"]) == 1.0

    def test_generator_that_stays_away_is_reported_unsafe(self, rig, bench):
        rig.set("generator", "frequency", 12.5)
        bench.close()
        (report,) = rig.make_safe()
        assert not report.safe
        assert "make safe failed" in report.problems[0]


def test_trial_of_the_plugin_works():
    device = instrument("pymeasure", REGISTRY.find("device", "pymeasure").record.trial)
    assert device.connect(1.0).simulated
    device.set("output", 2.5)
    assert device.read_back("output") == 2.5
    assert device.read(["voltage"])
    assert device.make_safe() == {"output": 0.0}
    device.close()


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"instrument": "os.system"}, "instrument"),
        ({"instrument": "pymeasure.instruments"}, "instrument"),
        ({"instrument": "pymeasure.adapters.VISAAdapter"}, "instrument"),
        ({"instrument": "evil.pymeasure.instruments.keithley.Keithley2000"}, "instrument"),
        ({"instrument": "pymeasure.instruments.keithley.Keithly2000"}, "did you mean Keithley2000"),
        ({"instrument": "pymeasure.instruments.keithly.Keithley2000"}, "cannot be loaded"),
        ({"instrument": "pymeasure.instruments.keithley.keithley2000.Instrument"}, "no instrument"),
        ({"instrument": "pymeasure.instruments.keithley.keithley2000.KeithleyBuffer"}, "no instru"),
        ({"channels": {"u": {"property": "voltge", "unit": "V"}}}, "did you mean voltage"),
        ({"channels": {"u": {"property": "adapter", "unit": "V"}}}, "no property 'adapter'"),
        ({"channels": {"u": {"property": "__class__", "unit": "V"}}}, "property"),
        ({"channels": {"u": {"property": "_x.y", "unit": "V"}}}, "property"),
        ({"connection": {"baud_rate": [9600]}}, "expected a number, a text, true or false"),
        ({"calls": ["write"]}, "no method 'write' that needs no arguments"),
        ({"calls": ["__init__"]}, "calls"),
        ({"channels": {}}, "neither channels nor drives"),
        ({"simulated": "yes"}, "simulated needs @sim"),
        ({"instrument": "pymeasure.instruments.fakes.SwissArmyFake"}, "write 'simulated: yes'"),
    ],
)
def test_invalid_settings_are_refused_before_connecting(changes, message):
    with pytest.raises(PluginError, match=message):
        instrument("pymeasure", merged(KEITHLEY, **changes))


class TestUnits:
    """PyMeasure's values are plain numbers; their unit is in the property's description."""

    @pytest.mark.parametrize(
        ("instrument_name", "name", "unit"),
        [
            ("keithley.Keithley2000", "voltage", "V"),  # 'measurement in Volts, based on'
            ("keithley.Keithley2000", "temperature", "°C"),  # 'measurement in Celsius'
            ("agilent.Agilent33220A", "frequency", "Hz"),  # '(float, in Hz)'
            ("srs.SR830", "theta", "deg"),
            ("lakeshore.LakeShore211", "temperature_kelvin", "K"),
            ("keithley.Keithley2000", "mode", ""),
        ],
    )
    def test_unit_is_read_from_the_description_of_a_property(self, instrument_name, name, unit):
        class_ = instrument_class(f"pymeasure.instruments.{instrument_name}")
        assert unit_in_description(class_, name) == unit

    @pytest.mark.parametrize("unit", ["mV", "N·m", "A"])
    def test_different_unit_without_a_scale_is_refused(self, unit):
        channel = {"property": "voltage", "unit": unit}
        with pytest.raises(PluginError, match=f"voltage of Keithley2000 is in V, .* has {unit} "):
            instrument("pymeasure", merged(KEITHLEY, channels={"u": channel}))

    @pytest.mark.parametrize(
        "channel", [{"unit": "V"}, {"unit": "mV", "scale": 1000}, {"unit": "N·m", "scale": 1}]
    )
    def test_same_unit_or_one_with_a_scale_is_accepted(self, channel):
        channel = {"property": "voltage", **channel}
        assert instrument("pymeasure", merged(KEITHLEY, channels={"u": channel}))

    def test_different_unit_of_a_drive_is_refused(self):
        drive = {**FREQUENCY, "unit": "rpm"}
        with pytest.raises(PluginError, match="frequency of Agilent33220A is in Hz"):
            instrument("pymeasure", merged(AGILENT, drives={"frequency": drive}))


def test_channel_that_the_instrument_lacks_is_reported():
    device = simulated(KEITHLEY, channels={"u": {"property": "ch_1.voltage", "unit": "V"}})
    device.connect(2.0)
    with pytest.raises(DeviceRejectedError, match=r"Keithley2000 has no channel 'ch_1'"):
        device.read(["u"])
    device.close()


def test_missing_package_is_reported_on_connect_only(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "pymeasure.instruments", None)
    device = simulated(KEITHLEY)
    with pytest.raises(PluginError, match=r"'pymeasure' is not installed.*rigrunner\[pymeasure\]"):
        device.connect(1.0)
