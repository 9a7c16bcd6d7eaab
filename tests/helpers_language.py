"""A small procedure and station as texts to spoil, and devices that are never connected."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, Any, Self

import pytest
from pydantic import Field, model_validator

from rigrunner.api.devices import ChannelInfo, DriveInfo
from rigrunner.api.errors import InvalidFileError, PluginError, Problem
from rigrunner.api.hooks import AnalysisRecord, PluginRecord
from rigrunner.api.plugin_refs import FitRef, OutlierRuleRef, PluginRef
from rigrunner.api.settings import (
    Length,
    ListOf,
    MomentOfInertia,
    PlainText,
    RotationalDamping,
    Settings,
    Torque,
    YesNo,
)


class Drive(Settings):
    """The keys of the rig that a plugin of these tests declares."""

    mandrel: PlainText = ""
    eccentric: Annotated[Length | None, Field(gt=0)] = None
    centre_distance: Annotated[Length | None, Field(gt=0)] = None
    inertia: MomentOfInertia | None = None
    support_friction: Torque | None = None
    support_damping: RotationalDamping | None = None

    @model_validator(mode="after")
    def _the_bar_moves(self) -> Self:
        if self.eccentric and self.centre_distance and self.eccentric >= self.centre_distance:
            raise ValueError("eccentric must be less than centre_distance")
        return self


PROCEDURE = """\
rigrunner: procedure/2
id: TEST-1
revision: "A"
title: A test
measurand: {symbol: Td, name: torque, unit: N·m}
inputs:
  specimen: {ask: Serial number, unattended: S-1}
uses: {tester: swing_tester}
parameters:
  load: 1000 N
  frequencies: [2 Hz, 10 Hz]
setup:
  - confirm: {text: Guards closed, unattended: yes}
  - ask: {text: Remarks, into: remarks, unattended: none}
  - set: {tester.load: 0 N, tester.frequency: 0 Hz}
  - zero: {channel: tester.torque, within: 0.05 N·m}
main:
  - set: {tester.load: $load}
  - sweep:
      set: tester.frequency
      over: $frequencies
      steps:
        - settle: {cycles: 5}
        - record: {channels: [tester.angle, tester.torque], cycles: 30}
teardown:
  - set: {tester.frequency: 0 Hz}
analysis:
  - swing_torque:
      no_load: {from: latest, procedure: TEST-0, max_age: 30 d, same: [station, mandrel]}
      despike: {hampel: {window: 11}}
      outliers: {grubbs: {alpha: 0.05}}
      fits:
        - polynomial: {degree: 2}
        - inertia
      compensations:
        - template
        - energy
      primary: template
acceptance:
  limits:
    - of: torque
      mean: yes
      max: 0.95 N·m
      source: nobody
      measurand: {nature: load_induced, condition: at_reversal}
  rule: guard_band_u
"""

STATION = """\
rigrunner: station/1
id: bench-1
title: A bench
rig:
  mandrel: M-01
  eccentric: 2 mm
  centre_distance: 45 mm
  inertia: 0.00233 kg·m²
  support_friction: 0.76 N·m
  support_damping: 0.31 N·m·s/rad
devices:
  tester:
    type: swing_tester
    plugin: fake
    settings: {gain: 1 N·m}
instruments:
  - channel: tester.torque
    serial: T-1
    full_scale: 10 N·m
    accuracy: {gain: 0.3 %, offset: 0.02 N·m, drift: 0.02 N·m, nonlinearity: 0.05 %}
    low_pass: {type: butterworth, order: 2, corner: 1 kHz}
"""


def edited(text: str, *changes: tuple[str, str]) -> str:
    """Return the text with each part, which must be there once, replaced."""
    for old, new in changes:
        assert text.count(old) == 1, f"{old!r} stands {text.count(old)} times"
        text = text.replace(old, new)
    return text


def place_of(text: str, part: str) -> str:
    """Return `line:column` of the first time that a part stands in a text."""
    before = text[: text.index(part)]
    return f"{before.count(chr(10)) + 1}:{len(before) - before.rfind(chr(10))}"


def problems_of(function, *arguments) -> tuple[Problem, ...]:
    """Return the problems with which a call is refused."""
    with pytest.raises(InvalidFileError) as caught:
        function(*arguments)
    return caught.value.problems


def only_problem(function, *arguments) -> Problem:
    """Return the one problem with which a call is refused."""
    (problem,) = problems_of(function, *arguments)
    return problem


class Unconnected:
    """A device as a plan sees it: nobody talks to it."""

    non_blocking = True

    def __init__(self, channels: tuple[ChannelInfo, ...], drives: tuple[DriveInfo, ...]) -> None:
        self.channels = channels
        self.drives = drives

    def connect(self, timeout_s):
        raise NotImplementedError

    make_safe = close = connect


class Streamer(Unconnected):
    """A device that records at 1 kHz."""

    sample_rate_hz = 1000.0

    def stream(self, channels, duration_s, stop):
        raise NotImplementedError


class Reader(Unconnected):
    """A device that gives single values."""

    def read(self, channels):
        raise NotImplementedError

    set = read_back = read


TESTER = Streamer(
    (
        ChannelInfo("angle", "rad", "swing angle"),
        ChannelInfo("torque", "N·m", "torque"),
        ChannelInfo("load", "N", "radial load"),
    ),
    (
        DriveInfo("load", "N", "radial load", 0.0, 3000.0, rate_per_s=500.0),
        DriveInfo(
            "frequency", "Hz", "swing", 0.0, 35.0, rate_per_s=10.0, sets_cycle_frequency=True
        ),
    ),
)
THERMOMETER = Unconnected((ChannelInfo("room", "K", "room temperature"),), ())
LOGGER = Streamer((ChannelInfo("torque", "N·m", "a second torque"),), ())


class FakeSettings(Settings):
    gain: Torque
    quiet: YesNo = False


class GrubbsSettings(Settings):
    alpha: float = 0.05


class FractionSettings(Settings):
    fraction: float = Field(le=5)


class PolynomialSettings(Settings):
    degree: int
    powers: ListOf[int] = ()


class CompensationRef(PluginRef):
    """A plugin of a kind that another package brings."""

    kind = "compensation"


class TorqueSettings(Settings):
    """Settings of an analysis that name other plugins."""

    no_load: Any = None
    despike: Any = None
    outliers: OutlierRuleRef | None = None
    fits: ListOf[FitRef] = ()
    compensations: ListOf[CompensationRef] = ()
    primary: str = ""


@dataclass(frozen=True)
class Lookup:
    """Plugins by kind and name, as a registry would know them."""

    known: dict[tuple[str, str], type[Settings]] = field(
        default_factory=lambda: {
            ("analysis", "swing_torque"): TorqueSettings,
            ("device", "fake"): FakeSettings,
            ("outlier_rule", "grubbs"): GrubbsSettings,
            ("decision_rule", "guard_band_u"): Settings,
            ("decision_rule", "guard_band_fraction"): FractionSettings,
            ("fit", "polynomial"): PolynomialSettings,
            ("fit", "inertia"): Settings,
            ("compensation", "template"): Settings,
            ("compensation", "energy"): Settings,
        }
    )

    def settings_of(self, kind: str, name: str) -> type[Settings]:
        if (kind, name) not in self.known:
            raise PluginError(f"there is no {kind} '{name}'", hint="did you mean another?")
        return self.known[kind, name]

    def record(self, kind: str, name: str) -> PluginRecord:
        model = self.settings_of(kind, name)
        if kind != "analysis":
            return PluginRecord(name=name, help="", settings=model)
        return AnalysisRecord(
            name=name,
            help="",
            settings=model,
            factory=lambda _: None,
            yields=lambda _: (),
            measurand="torque",
        )

    def rig_model(self) -> type[Settings]:
        return Drive

    def rig_of(self, kind: str, name: str) -> type[Settings] | None:
        self.settings_of(kind, name)
        return Drive if kind == "compensation" else None
