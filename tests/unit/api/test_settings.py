"""Field types of settings that are read from YAML, and the checks of instruments."""

from __future__ import annotations

import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from datetime import date

import pytest
from pydantic import ValidationError

from rigrunner.api.instruments import Instrument
from rigrunner.api.quantity import parse_quantity
from rigrunner.api.settings import AnyQuantity, Force, Frequency, IsoDate, ListOf, Settings, YesNo

INSTRUMENT = {
    "channel": "tester.torque",
    "serial": "T-1",
    "full_scale": "10 N·m",
    "accuracy": {"gain": "0.3 %", "offset": "0.02 N·m", "drift": "0 N·m", "nonlinearity": "0 %"},
}


class Example(Settings):
    load: Force = 0.0
    loads: ListOf[Force] = ()
    due: IsoDate | None = None
    quiet: YesNo = False
    anything: AnyQuantity | None = None


def test_quantities_are_stored_in_si():
    assert Example.model_validate({"load": "1.5 kN"}).load == 1500.0
    assert Example(load=parse_quantity("1.5 kN")).load == 1500.0
    assert Example.model_validate({"loads": ["1 N", "2 kN"]}).loads == (1.0, 2000.0)
    assert str(Example.model_validate({"anything": "2100 rpm"}).anything) == "2100 rpm"


@pytest.mark.parametrize("value", [5, 5.0, True, None, ["1 N"], "1 Hz", "5"])
def test_value_that_is_no_force_is_refused(value):
    with pytest.raises(ValidationError):
        Example.model_validate({"load": value})


def test_dates_and_yes_no_are_parsed():
    assert Example.model_validate({"due": "2026-02-28"}).due == date(2026, 2, 28)
    assert Example.model_validate({"quiet": "yes"}).quiet is True
    with pytest.raises(ValidationError, match="2026-02-30"):
        Example.model_validate({"due": "2026-02-30"})
    with pytest.raises(ValidationError, match="expected yes or no"):
        Example.model_validate({"quiet": "on"})
    with pytest.raises(ValidationError):
        Example.model_validate({"due": 20260228})


def test_models_are_frozen_and_refuse_unknown_keys():
    with pytest.raises(ValidationError):
        Example().load = 5.0
    with pytest.raises(ValidationError):
        Example.model_validate({"lod": "5 N"})


def test_schema_describes_the_accepted_values():
    properties = Example.model_json_schema()["properties"]

    assert properties["load"]["type"] == "string"
    assert "kN" in properties["load"]["description"]
    assert properties["quiet"]["enum"] == ["yes", "no", True, False]


@pytest.mark.parametrize(
    ("key", "value"),
    [("full_scale", "0 N·m"), ("low_pass", {"corner": "0 Hz"}), ("low_pass", {"corner": "1 N"}),
     ("low_pass", {"corner": "1 kHz", "order": 9}), ("calibrated", "yesterday"), ("serial", 5)],
)  # fmt: skip
def test_invalid_instrument_is_refused(key, value):
    with pytest.raises(ValidationError):
        Instrument.model_validate(INSTRUMENT | {key: value})


@pytest.fixture
def frequent_switches():
    """Let threads switch as often as possible."""
    before = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    yield
    sys.setswitchinterval(before)


@pytest.mark.usefixtures("frequent_switches")
@pytest.mark.parametrize("_", range(20))
def test_concurrent_first_use_of_a_model_works_in_all_threads(_):
    """It is built on first use; with pydantic 2.11 another thread would get its base instead."""

    class Inner(Settings):
        at: ListOf[Frequency]

    class Outer(Settings):
        inner: Inner
        force: Force

    together = threading.Barrier(8)

    def first_use(_: int) -> Outer:
        together.wait(10)
        return Outer.model_validate({"inner": {"at": ["1 kHz"]}, "force": "2 kN"})

    with ThreadPoolExecutor(8) as threads:
        results = list(threads.map(first_use, range(8)))
    assert all(result.force == 2000.0 and result.inner.at == (1000.0,) for result in results)
