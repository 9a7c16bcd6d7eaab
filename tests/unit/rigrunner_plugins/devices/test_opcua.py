"""OPC UA nodes against asyncua's own server: reading, driving, comparing, and failures."""

from __future__ import annotations

import asyncio
import sys
import threading
import time
from contextlib import contextmanager

import pytest
from asyncua import Client, ua
from pydantic import ValidationError

from helpers_devices import plan_of, run
from rigrunner.api.errors import (
    DeviceLostError,
    DeviceNotFoundError,
    DeviceRejectedError,
    DeviceTimeoutError,
    MissingPackageError,
)
from rigrunner.api.events import Outcome
from rigrunner.clock import WallClock
from rigrunner.registry import load_registry
from rigrunner.steps.set_drives import SetDrive
from rigrunner_plugins.devices.opcua.session import UNECE, symbol_of, unit_id
from rigrunner_plugins.devices.opcua.settings import OpcUaSettings
from rigrunner_plugins.devices.opcua.types import TYPES, encode
from rigrunner_testing import subject
from unit.rigrunner_plugins.devices.helpers_conformance import (
    applicable,
    assert_it_conforms,
    assert_not_applicable,
)
from unit.rigrunner_plugins.devices.helpers_modbus import Cable
from unit.rigrunner_plugins.devices.helpers_opcua import APPLICATION, DRIVE, PASSWORD, Bench, device

TORQUE = {"node": "ns=2;s=Torque", "unit": "N·m"}


@pytest.fixture(scope="module")
def bench(tmp_path_factory):
    bench_ = Bench(tmp_path_factory.mktemp("opcua")).start()
    yield bench_
    bench_.stop()


def settings(bench, **more):
    settings = {
        "endpoint": bench.endpoint,
        "timeout": "9 s",
        "channels": {"torque": TORQUE},
        **more,
    }
    return {key: value for key, value in settings.items() if value is not None}


@contextmanager
def connected(bench, **more):
    unit = device(settings(bench, **more), bench.folder)
    unit.connect(5.0)
    try:
        yield unit
    finally:
        unit.close()


def refused(bench, **more):
    with (
        pytest.raises((DeviceRejectedError, DeviceNotFoundError)) as raised,
        connected(bench, **more),
    ):
        pass
    return str(raised.value)


def test_nodes_are_read_in_their_units(bench):
    channels = {
        "torque": TORQUE,
        "temperature": {"node": "ns=2;s=Temperature", "unit": "°C", "type": "Float"},
        "count": {"node": "nsu=urn:rigrunner:test;s=Count", "unit": "mm", "scale": 0.5},
        "enabled": {"node": "ns=2;s=Enable", "unit": "1"},
    }
    with connected(bench, channels=channels) as plc:
        assert plc.read(list(channels)) == {
            "torque": 1.25,
            "temperature": pytest.approx(294.65),
            "count": pytest.approx(0.0035),  # 7 * 0.5 mm
            "enabled": 0.0,
        }


def test_drive_is_set_and_stopped(bench):
    with connected(bench, drives={"frequency": DRIVE}) as plc:
        plc.set("frequency", 12.5)
        assert (bench.value("Set"), bench.value("Enable")) == (12.5, True)
        assert plc.read_back("frequency") == 12.5
        assert plc.make_safe() == {"frequency": 0.0}
        assert (bench.value("Set"), bench.value("Enable")) == (0.0, False)


def test_read_back_is_the_measured_value(bench):
    with connected(bench, drives={"frequency": {**DRIVE, "run": []}}) as plc:
        plc.begin("frequency", 12.5)
        assert bench.value("Set") == 12.5
        assert plc.read_back("frequency") == 0.0  # it was not enabled
        assert not plc.arrived("frequency")
        plc.make_safe()


def test_refused_write_is_reported_and_made_safe(bench):
    with connected(bench, drives={"frequency": DRIVE}) as plc:
        bench.allow("Set", writing=False)
        try:
            with pytest.raises(DeviceRejectedError, match=r"write 5.0 to ns=2;s=Set: .* says Bad"):
                plc.begin("frequency", 5.0)
        finally:
            bench.allow("Set", writing=True)
        assert plc.make_safe() == {"frequency": 0.0}


def test_identity_is_read_and_compared(bench):
    identification = {"serial": "ns=2;s=Label", "expect": {"serial": "bench 7"}}
    unit = device(settings(bench, identification=identification), bench.folder)
    identity = unit.connect(5.0)
    unit.close()
    assert (identity.maker, identity.serial) == ("FreeOpcUa", "bench 7")
    message = refused(bench, identification={**identification, "expect": {"serial": "bench 8"}})
    assert "has the serial 'bench 7', expected 'bench 8'" in message


def test_missing_maker_is_unknown(bench, monkeypatch):
    unit = device(settings(bench), bench.folder)
    monkeypatch.setattr(unit, "_ask_identity", lambda: ["", "PLC", "", ""])
    identity = unit.connect(5.0)
    unit.close()
    assert (identity.maker, identity.model, identity.serial) == ("unknown", "PLC", "not told")


@pytest.mark.parametrize("mode", ["sign", "sign_and_encrypt"])
def test_signed_channel_and_user_are_accepted(bench, mode):
    (bench.folder / "password").write_text(f"{PASSWORD}\n", encoding="utf-8")
    security = {
        "mode": mode,
        "certificate": "client.der",
        "private_key": "client.pem",
        "server_certificate": "server.der",
    }
    user = {"name": "lab", "password_file": "password"}
    with connected(bench, security=security, user=user) as plc:
        assert plc.read(["torque"]) == {"torque": 1.25}
        client = plc._session._client
        assert client.application_uri == APPLICATION  # as in the client's certificate
        assert client.security_policy.Mode.name.lower() == mode.replace("_and_", "and")


def test_user_who_may_not_log_in_is_reported(bench):
    (bench.folder / "wrong").write_text("guess", encoding="utf-8")
    message = refused(bench, user={"name": "lab", "password_file": "wrong"})
    assert "refuses the connection: BadUserAccessDenied" in message or "BadIdentityToken" in message
    message = refused(bench, user={"name": "lab", "password_file": "nowhere"})
    assert "nowhere cannot be read" in message


@pytest.mark.parametrize("name", ["/etc/hostname", "../secret"])
def test_password_file_outside_the_folder_is_not_sent(bench, name):
    message = refused(bench, user={"name": "lab", "password_file": name})
    assert f"{name} is outside the station's folder" in message
    security = {"certificate": name, "private_key": name, "server_certificate": name}
    assert "is outside the station's folder" in refused(bench, security=security)


def test_invalid_certificates_are_reported(bench):
    files = {"certificate": "client.der", "private_key": "client.pem"}
    message = refused(bench, security={**files, "server_certificate": "nowhere.der"})
    assert "nowhere.der cannot be read: No such file" in message
    (bench.folder / "text.der").write_text("text", encoding="utf-8")
    message = refused(bench, security={**files, "server_certificate": "text.der"})
    assert "the certificates of `security` cannot be used" in message


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ({"channels": {"torque": {**TORQUE, "unit": "N"}}}, "is in N·m, as its EngineeringUnits"),
        ({"channels": {"torque": {**TORQUE, "unit": "mN·m"}}}, "the station says mN·m"),
        ({"channels": {"torque": {**TORQUE, "type": "Float"}}}, "is a Double, the station states"),
        ({"channels": {"torque": {**TORQUE, "node": "ns=2;s=Torqe"}}}, "BadNodeIdUnknown"),
        ({"channels": {"torque": {**TORQUE, "node": "nsu=urn:x;s=T"}}}, "no namespace 'urn:x'"),
        ({"channels": {"label": {"node": "ns=2;s=Label", "unit": "1"}}}, "holds String, expected"),
        ({"drives": {"f": {**DRIVE, "node": "ns=2;s=Locked"}}}, "s=Locked cannot be written"),
        ({"drives": {"f": {**DRIVE, "node": "ns=2;s=Coarse"}}}, "UInt16 has steps of 1 Hz"),
        (
            {"drives": {"f": {**DRIVE, "run": [{"node": "ns=2;s=No", "value": 1}]}}},
            "BadNodeIdUnknown",
        ),
    ],
)
def test_mismatch_with_the_station_is_refused_before_anything_moves(bench, more, message):
    assert message in refused(bench, **more)
    assert bench.value("Enable") is False


def test_check_of_units_can_be_turned_off(bench):
    other = {"torque": {**TORQUE, "unit": "N"}}
    with connected(bench, channels=other, check_units="no") as plc:
        assert plc.read(["torque"]) == {"torque": 1.25}


def test_value_with_bad_status_is_refused(bench):
    with connected(bench) as plc:
        for code, name in (
            (ua.StatusCodes.BadSensorFailure, "BadSensorFailure"),
            (ua.StatusCodes.UncertainLastUsableValue, "UncertainLastUsableValue"),
        ):
            bench.put("Torque", 9.9, ua.VariantType.Double, status=code)
            with pytest.raises(DeviceRejectedError, match=rf"s=Torque has no good value: {name}"):
                plc.read(["torque"])
        bench.put("Torque", 1.25, ua.VariantType.Double)
        assert plc.read(["torque"]) == {"torque": 1.25}


def test_stale_value_is_refused(bench):
    fresh = {"torque": {**TORQUE, "stale": "5 s"}}
    with connected(bench, channels=fresh) as plc:
        bench.put("Torque", 1.25, ua.VariantType.Double, age_s=4.0)
        assert plc.read(["torque"]) == {"torque": 1.25}
        for age_s, age in ((6.0, r"6[.\d]*"), (-6.0, r"-(6|5\.\d+)")):  # the clocks do not agree
            bench.put("Torque", 1.25, ua.VariantType.Double, age_s=age_s)
            with pytest.raises(DeviceRejectedError, match=rf"is {age} s old, more than 5"):
                plc.read(["torque"])
    bench.put("Torque", 1.25, ua.VariantType.Double)


def test_array_is_not_accepted_as_a_number(bench):
    channels = {"many": {"node": "ns=2;s=Many", "unit": "1"}}
    with (
        connected(bench, channels=channels) as plc,
        pytest.raises(DeviceRejectedError, match="s=Many holds an array"),
    ):
        plc.read(["many"])


def test_missing_package_names_the_extra(bench, monkeypatch):
    monkeypatch.setitem(sys.modules, "asyncua", None)
    monkeypatch.delitem(sys.modules, "rigrunner_plugins.devices.opcua.session", raising=False)
    with pytest.raises(MissingPackageError, match=r"'asyncua' is not installed.*rigrunner\[opcua"):
        device(settings(bench)).connect(1.0)


def test_unreachable_server_is_reported(bench):
    unit = device(settings(bench, endpoint="opc.tcp://127.0.0.1:1"))
    with pytest.raises(
        DeviceNotFoundError, match=r"opc.tcp://127.0.0.1:1 cannot be reached: Connection refused"
    ):
        unit.connect(2.0)


def test_server_that_does_not_answer_times_out(bench):
    cable = Cable(bench.port)
    cable.swallow()
    threads = threading.active_count()
    start_s = time.monotonic()
    unit = device(settings(bench, endpoint=f"opc.tcp://127.0.0.1:{cable.port}", timeout="300 ms"))
    with pytest.raises(DeviceTimeoutError, match="does not answer within"):
        unit.connect(60.0)
    assert time.monotonic() - start_s < 30.0
    cable.close()
    until_s = time.monotonic() + 5.0
    while threading.active_count() > threads and time.monotonic() < until_s:
        time.sleep(0.02)
    assert threading.active_count() <= threads


def test_requests_of_a_call_share_the_time_limit_of_an_answer(bench, monkeypatch):
    """The station's limit of a call is longer: otherwise it would give up the device first."""
    by_uri = {"torque": {**TORQUE, "node": "nsu=urn:rigrunner:test;s=Torque"}}
    with connected(bench, timeout="1500 ms", channels=by_uri) as plc:

        def slow(request):
            async def answer(*args):
                await asyncio.sleep(1.0)
                return await request(*args)

            return answer

        for name in ("get_namespace_index", "read_attributes"):
            monkeypatch.setattr(Client, name, slow(getattr(Client, name)))
        with pytest.raises(DeviceTimeoutError, match="no answer from"):
            plc.read(["torque"])


MAIN = (SetDrive("tester", "frequency", 10.0, "Hz"), SetDrive("tester", "frequency", 20.0, "Hz"))


@pytest.fixture
def cable(bench):
    cable_ = Cable(bench.port)
    yield cable_
    cable_.close()


def run_with(bench, cable, break_it):
    endpoint = f"opc.tcp://127.0.0.1:{cable.port}/bench"
    plc = device(settings(bench, endpoint=endpoint, drives={"frequency": DRIVE}, timeout="1500 ms"))

    def at(event):
        if getattr(event, "index", None) == 1:
            break_it()

    summary = run(plc, plan_of((), MAIN, ()), critical=[at], clock=WallClock())
    plc.close()
    return summary


def test_dropped_connection_is_reopened_to_stop_the_motor(bench, cable):
    summary = run_with(bench, cable, cable.drop)
    assert summary.outcome is Outcome.ERROR
    assert isinstance(summary.error, DeviceLostError)
    assert "closed the connection or was unplugged" in str(summary.error)
    assert summary.safe
    assert (bench.value("Set"), bench.value("Enable")) == (0.0, False)


@pytest.mark.in_real_time
def test_pulled_cable_leaves_a_rig_reported_unsafe(bench, cable):
    summary = run_with(bench, cable, cable.swallow)
    assert summary.outcome is Outcome.ERROR
    assert isinstance(summary.error, DeviceTimeoutError)
    assert "no answer from opc.tcp://127.0.0.1" in str(summary.error)
    assert not summary.safe
    with connected(bench, drives={"frequency": DRIVE}) as plc:
        assert plc.make_safe() == {"frequency": 0.0}


@pytest.fixture
def opcua_subject(bench):
    settings_ = settings(
        bench, drives={"frequency": DRIVE}, identification={"serial": "ns=2;s=Label"}
    )
    return subject("device", "opcua", settings_, registry=load_registry(), folder=bench.folder)


@pytest.mark.parametrize("check", applicable("device", "opcua"), ids=str)
def test_opcua_device_conforms(opcua_subject, check):
    assert_it_conforms(opcua_subject, check)


def test_checks_that_do_not_apply_say_why(opcua_subject):
    assert_not_applicable(opcua_subject)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"endpoint": "http://127.0.0.1"}, "is not an endpoint; expected such as opc.tcp"),
        ({"endpoint": "opc.tcp://lab:pw@127.0.0.1"}, "without user and password"),
        ({"channels": {}}, "neither channels nor drives"),
        ({"channels": {"a": {"node": "Torque", "unit": "N"}}}, "'Torque' is not a node id"),
        ({"channels": {"a": {**TORQUE, "type": "String"}}}, "type"),
        ({"drives": {"f": {**DRIVE, "type": "UInt16"}}}, "UInt16 has steps of 1 Hz"),
        (
            {"drives": {"f": {**DRIVE, "type": "Byte", "max": "300 Hz", "tolerance": "1 Hz"}}},
            "300 does not fit into Byte: 0 to 255",
        ),
        (
            {"drives": {"f": {**DRIVE, "read_back": {"node": "i=1", "unit": "N"}}}},
            "read_back is in N, the drive in Hz",
        ),
    ],
)
def test_contradictory_settings_are_refused(changes, message):
    settings = {"endpoint": "opc.tcp://plc:4840", "channels": {"torque": TORQUE}, **changes}
    with pytest.raises(ValidationError, match=message):
        OpcUaSettings.model_validate(settings)


@pytest.mark.parametrize(
    ("code", "number", "symbol"),
    [
        # from the OPC Foundation's table UNECE_to_OPCUA.csv
        ("CEL", 4408652, "°C"),
        ("HTZ", 4740186, "Hz"),
        ("NU", 20053, "N·m"),
        ("NEW", 5129559, "N"),
        ("C81", 4405297, "rad"),
    ],
)
def test_units_by_their_common_code(code, number, symbol):
    assert unit_id(code) == number
    assert symbol_of(UNECE, number, None) == symbol


def test_units_by_their_text():
    assert symbol_of("urn:acme", 4408652, "Nm") == "N·m"
    assert symbol_of(None, 0, "counts") == symbol_of(None, 0, None) == ""


def test_every_type_refuses_values_out_of_range():
    limits = {"Byte": (0, 255), "SByte": (-128, 127), "Int64": (-(2**63), 2**63 - 1)}
    for type_, (low, high) in limits.items():
        assert (encode(low, type_), encode(low + 0.4, type_)) == (low, low)
        with pytest.raises(ValueError, match="does not fit"):
            encode(high * 1.01 + 1, type_)
    for type_ in TYPES:
        with pytest.raises(ValueError, match="not a number"):
            encode(float("nan"), type_)
    with pytest.raises(ValueError, match=r"0\.5 does not fit into Boolean"):
        encode(0.5, "Boolean")
    assert encode(1.0, "Boolean") is True
