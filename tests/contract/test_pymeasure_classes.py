"""Every instrument class of PyMeasure: whether a station can use it without code.

The numbers in docs/how-to/use-a-pymeasure-driver.md are checked here.
"""

from __future__ import annotations

import importlib
import inspect
import pkgutil
import re
import warnings
from contextlib import suppress
from pathlib import Path
from typing import ClassVar
from unittest.mock import MagicMock

import pymeasure
import pymeasure.instruments
import pytest
from pymeasure.adapters import Adapter
from pymeasure.instruments import Instrument

from rigrunner.api.devices import Device
from rigrunner.api.errors import DeviceError
from rigrunner_plugins.devices.pymeasure.binding import instrument_class, properties_of
from unit.rigrunner_plugins.devices.helpers_instruments import instrument

PAGE = Path(__file__).parents[2] / "docs/how-to/use-a-pymeasure-driver.md"
NO_INSTRUMENTS = {"pymeasure.instruments.fakes"}


def _modules():
    """Return the modules that can be loaded; some need a package or driver of their maker."""
    for module_info in pkgutil.walk_packages(
        pymeasure.instruments.__path__, "pymeasure.instruments."
    ):
        if module_info.name in NO_INSTRUMENTS:
            continue
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            try:
                yield importlib.import_module(module_info.name)
            except (ImportError, OSError, AttributeError):
                continue


@pytest.fixture(scope="module")
def classes():
    """Return each class once, by its shortest qualified name."""
    names_of = {}
    for module in _modules():
        for name, member in vars(module).items():
            if (
                inspect.isclass(member)
                and issubclass(member, Instrument)
                and member.__module__.startswith("pymeasure.instruments.")
                and member.__module__ not in {*NO_INSTRUMENTS, "pymeasure.instruments.instrument"}
                and not name.startswith("_")
            ):
                names_of.setdefault(member, set()).add(f"{module.__name__}.{name}")
    return sorted(min(names, key=lambda name: (len(name), name)) for names in names_of.values())


def obstacle(instrument_type):
    """Return why a station cannot use a class; empty if it can."""
    parameters = inspect.signature(instrument_type.__init__).parameters
    if "adapter" not in parameters:
        return "it does not take the name of a VISA resource"
    if not any(parameter.kind is parameter.VAR_KEYWORD for parameter in parameters.values()):
        return "it takes nothing that says how to connect"
    return "" if properties_of(instrument_type) else "it has no properties"


@pytest.fixture(scope="module")
def usable(classes):
    return [name for name in classes if not obstacle(instrument_class(name))]


def test_most_instruments_can_be_used(classes, usable):
    assert len(usable) > 150
    assert len(usable) >= 0.95 * len(classes)


def test_numbers_on_the_page_are_right(classes, usable):
    counts = re.search(
        r"(\d+) of its (\d+) instrument classes, from (\d+) makers", PAGE.read_text()
    )
    assert counts is not None
    version = re.search(r"[Oo]f\s+PyMeasure\s+([\d.]+)", PAGE.read_text())[1]
    if not pymeasure.__version__.startswith(version):
        pytest.skip(f"they were counted in {version}, this is {pymeasure.__version__}")
    makers = {name.split(".")[2] for name in usable}
    assert [int(count) for count in counts.groups()] == [len(usable), len(classes), len(makers)]


def bound(name):
    """Return a channel of a property, whatever its unit."""
    return {"property": name, "unit": "1", "scale": 1}


class Connection(Adapter):
    """Replaces the VISA adapter of PyMeasure, and answers 1 to everything."""

    opened: ClassVar[list[tuple]] = []

    def __init__(self, resource, **keywords):
        super().__init__()
        self.connection = MagicMock()
        self.opened.append((resource, keywords))

    def _write(self, command, **keywords):
        pass

    _write_bytes = _write

    def _read(self, **_keywords):
        return "1"

    def _read_bytes(self, count, **_keywords):
        return b"1" * count


def test_each_class_gets_the_resource_and_backend_of_the_station(usable, monkeypatch):
    monkeypatch.setattr("pymeasure.instruments.instrument.VISAAdapter", Connection)
    for name in usable:
        Connection.opened.clear()
        settings = {
            "instrument": name,
            "resource": "GPIB0::5::INSTR",
            "channels": {"first": bound(properties_of(instrument_class(name))[0])},
        }
        with suppress(DeviceError):  # a few communicate at once, and refuse the answer 1
            instrument("pymeasure", settings).connect(1.0)
        opened = [(resource, keywords["visa_library"]) for resource, keywords in Connection.opened]
        assert opened == [("GPIB0::5::INSTR", "@py")], name


def test_a_station_can_bind_each_property_of_each_class(usable):
    for name in usable:
        channels = {
            f"channel_{number}": bound(prop)
            for number, prop in enumerate(properties_of(instrument_class(name)))
        }
        settings = {"instrument": name, "resource": "GPIB0::5::INSTR", "channels": channels}
        device = instrument("pymeasure", settings)
        assert isinstance(device, Device), name
        assert len(device.channels) == len(channels), name
