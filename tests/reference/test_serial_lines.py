"""Lines from makers' manuals, sent byte for byte over a serial line.

A&D, GH series instruction manual, 10.5 and 10.6, and FX-CT series, 'A&D standard format' and 'NU
(numerical) format': header ST (stable), US (unstable) or OL (overload), a comma, nine characters of
data, three of the unit. METTLER TOLEDO, MT-SICS reference manual for Excellence balances
(11780711B), 3.2.1: identification, status (S stable, D dynamic), ten characters of weight, unit;
3.2.3: ES for a command that is not known. KERN 470 series, data interface: sign, data, unit, S for
stable. The values are the manuals' examples or ours, the formats are theirs.
"""

from __future__ import annotations

import threading

import pytest

from rigrunner.api.errors import DeviceRejectedError
from rigrunner_plugins.devices.serial_ascii.settings import SerialAsciiSettings
from unit.rigrunner_plugins.devices.helpers_instruments import instrument, merged
from unit.rigrunner_plugins.devices.helpers_peers import Script, SerialPeer

AND = {
    "termination": "CRLF",
    "channels": {"mass": {"pattern": "ST,(.*)", "unit_in_answer": "g", "unit": "g"}},
    "ignore": "US,.*",
}
SICS = {
    "termination": "CRLF",
    # the weight hangs on a lever of 0.25 m: 1 g is 0.25 * 9.80665 = 2.4516625 mN·m
    "channels": {
        "torque": {
            "pattern": "S [SD] (.*)",
            "unit_in_answer": "g",
            "unit": "mN·m",
            "scale": 2.4516625,
        }
    },
}
KERN = {
    "termination": "CRLF",
    "channels": {"mass": {"pattern": r"^(.*) S$", "unit_in_answer": "G", "unit": "g"}},
}


def values(settings, line):
    model = SerialAsciiSettings.model_validate({"port": "/dev/ttyUSB0", **settings})
    return model.values_in(line)


@pytest.mark.parametrize(
    ("settings", "line", "expected"),
    [
        (AND, "ST,+00012.78  g", {"mass": 0.01278}),
        (AND, "ST,-00183.96  g", {"mass": -0.18396}),
        (SICS, "S S     100.00 g", {"torque": 0.24516625}),  # 100 g * 2.4516625 mN·m/g
        (SICS, "S D     -12.00 g", {"torque": -0.02941995}),  # -12 * 2.4516625 mN·m
        (KERN, "+ 00123.4 G S", {"mass": 0.1234}),
    ],
)
def test_line_of_manual_is_parsed(settings, line, expected):
    assert values(settings, line) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize(
    ("settings", "line"),
    [
        (AND, "OL,+9999999E+19"),  # overload
        (AND, "ST,+0001.278 ct"),  # carat: another unit
        (AND, "ST,+00012.78 kg"),
        (SICS, "ES"),
        (SICS, "S +"),  # overload
        (SICS, "S I"),  # cannot at present
        (KERN, "- 65.4321 KG S"),
        (KERN, "+ 00123.4 G E"),  # error
    ],
)
def test_unsuitable_line_is_rejected(settings, line):
    with pytest.raises(DeviceRejectedError, match="a line is"):
        values(settings, line)


def test_balance_that_sends_continuously():
    server = SerialPeer()
    device = instrument("serial_ascii", merged(AND, port=server.port, stale="500 ms"))
    server.say(b"0012.78  g\r\n")  # the end of an earlier line
    stream = b"US,-00183.96  g\r\nST,+00018.72  g\r\nUS,+00099.99  g\r\n"
    threading.Timer(0.1, server.say, (b"ST,+00001.00  g\r\n" + stream,)).start()
    device.connect(1.0)
    # the first received line may be incomplete, and unstable values are skipped
    assert device.read(["mass"]) == {"mass": pytest.approx(0.01872, rel=1e-12)}
    device.close()
    server.close()


def test_balance_that_is_queried():
    """SI asks for the weight at once, stable or not (MT-SICS, level 0)."""
    script = Script(
        [
            (b"@\r\n", b'I4 A "0123456789"\r\n'),  # @ resets, and is answered by the serial number
            (b"SI\r\n", b"S D     129.07 g\r\n"),
            (b"SI\r\n", b"S S     129.07 g\r\n"),
            (b"SI\r\n", b"S +\r\n"),
        ]
    )
    server = SerialPeer(script)
    settings = merged(SICS, port=server.port, request="SI", stale="500 ms")
    settings["identification"] = {"query": "@", "expect": 'I4 A "[0-9]+"'}
    device = instrument("serial_ascii", settings)
    assert device.connect(1.0).model == 'I4 A "0123456789"'
    # 129.07 g * 2.4516625 mN·m/g = 316.436078875 mN·m
    assert device.read(["torque"]) == {"torque": pytest.approx(0.316436078875, rel=1e-12)}
    with pytest.raises(DeviceRejectedError, match=r"'S \+'"):
        device.read(["torque"])
    device.close()
    server.close()
    assert not script.left
    assert not script.unexpected
