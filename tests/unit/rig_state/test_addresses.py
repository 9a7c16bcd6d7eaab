"""Spellings of one address are recognised, and different addresses kept apart."""

import sys

import pytest

from rigrunner.rig_state import canonical


@pytest.mark.skipif(sys.platform == "win32", reason="links of POSIX")
def test_links_to_a_serial_port_are_one_address(tmp_path):
    port = tmp_path / "ttyUSB0"
    port.touch()
    link = tmp_path / "by-id"
    link.symlink_to(port)
    assert canonical(f"serial:{link}") == canonical(f"serial:{port}")
    assert canonical(f"visa:ASRL{link}::INSTR") == canonical(f"serial:{port}")
    assert canonical(f"serial:{tmp_path}/ttyUSB1") != canonical(f"serial:{port}")


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ("tcp:localhost:5025", "tcp:127.0.0.1:5025"),
        ("tcp:[::1]:5025", "tcp:127.0.0.1:5025"),
        ("tcp:[::ffff:127.0.0.1]:5025", "tcp:127.0.0.1:5025"),
        ("tcp:localhost:502/unit 3", "tcp:127.0.0.1:502/unit 3"),
        ("visa:TCPIP::localhost::5025::SOCKET", "tcp:127.0.0.1:5025"),
        ("visa:TCPIP0::127.0.0.1::inst0::INSTR", "visa:TCPIP::localhost::INSTR"),
        ("visa:GPIB::12::INSTR", "visa:gpib0::12::INSTR"),
        ("visa:USB0::0x1AB1::0x0588::DS1::INSTR", "visa:USB::6833::1416::ds1::INSTR"),
        ("serial:COM3", "serial:com3"),
        ("serial:COM3", r"serial:\\.\COM3"),
        ("visa:ASRLCOM3::INSTR", "serial:COM3"),
        ("visa:my_psu", "visa:MY_PSU"),
        ("daq:Dev1", "daq:dev1"),
        ("daq:cDAQ1Mod2", "daq:cDAQ1"),
    ],
)
def test_different_spellings_are_one_address(one, other):
    assert canonical(one) & canonical(other)


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ("tcp:127.0.0.1:5025", "tcp:127.0.0.1:5026"),
        ("tcp:127.0.0.1:502/unit 3", "tcp:127.0.0.1:502/unit 4"),
        ("tcp:192.0.2.1:5025", "tcp:192.0.2.2:5025"),
        ("visa:GPIB0::12::INSTR", "visa:GPIB1::12::INSTR"),
        ("visa:GPIB0::12::INSTR", "visa:GPIB0::13::INSTR"),
        ("visa:TCPIP::192.0.2.1::inst0::INSTR", "visa:TCPIP::192.0.2.1::inst1::INSTR"),
        ("daq:Dev1", "daq:Dev2"),
        ("serial:COM3", "serial:COM4"),
        ("visa:my_psu", "visa:my_load"),
    ],
)
def test_different_places_are_different_addresses(one, other):
    assert not canonical(one) & canonical(other)


def test_unknown_host_is_kept_as_written():
    assert canonical("tcp:No-Such-Host.invalid:502") == {"tcp:no-such-host.invalid:502"}


def test_unknown_kind_of_address_is_kept_as_written():
    assert canonical("camera:42") == {"camera:42"}


@pytest.mark.parametrize(("platform", "port"), [("win32", "serial:COM1"), ("linux", "serial:1")])
def test_visa_serial_number_is_a_com_port_only_on_windows(platform, port, monkeypatch):
    monkeypatch.setattr(sys, "platform", platform)
    assert canonical("visa:ASRL1::INSTR") == {port}
