"""A plugin as a stranger writes it by hand, against the public API alone: every kind, every type.

mypy --strict checks it against the wheel; `test_new_plugin.py` runs it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import Field

from rigrunner.api import (
    AnalysisRecord,
    Answering,
    AnyQuantity,
    Approaching,
    Array,
    Block,
    CertificateFormatRecord,
    CertificateInput,
    ChannelInfo,
    Check,
    Clock,
    Column,
    Curve,
    DataError,
    DecisionRuleRecord,
    Device,
    DeviceContext,
    DeviceError,
    DeviceLostError,
    DeviceNotFoundError,
    DeviceRecord,
    DeviceRejectedError,
    DeviceTimeoutError,
    Distribution,
    DriveInfo,
    Driver,
    Duration,
    Effect,
    Estimate,
    Event,
    EventSink,
    EventSinkRecord,
    Findings,
    Fit,
    FitRecord,
    Force,
    Frequency,
    Identity,
    Importer,
    ImporterRecord,
    Input,
    Instrument,
    Limits,
    LineDriver,
    LineSettings,
    ListOf,
    Location,
    Mask,
    MeasurementModel,
    MeasurementResult,
    MissingPackageError,
    NeededChannel,
    NoSettings,
    NotInFileError,
    OutlierRule,
    OutlierRuleRecord,
    Pausable,
    Points,
    Quantity,
    Readable,
    Recording,
    Rejection,
    ReportFormatRecord,
    ReportInput,
    Requirements,
    ResultDefinition,
    RunData,
    Settable,
    Settings,
    Spreading,
    StopToken,
    Streaming,
    StudyFormatRecord,
    StudyInput,
    UnitDefinition,
    UnitRecord,
    Verdict,
    WrapperSettings,
    YesNo,
    Zone,
    hookimpl,
    parse_quantity,
)
from rigrunner.signal.coverage import expanded
from rigrunner.signal.inputs import limited, model_of
from rigrunner_bearings.api import CompensationRecord
from rigrunner_bearings.api.compensations import (
    CompensatedPoint,
    Compensation,
    CompensationMethod,
    Sweep,
)
from rigrunner_bearings.api.measurand import Condition, MeasurandKind, Nature
from rigrunner_bearings.api.points import PeakPoint, SwingPoint
from rigrunner_bearings.api.rig import RigDescription
from rigrunner_bearings.signal.compensated import compensated_point
from rigrunner_bearings.signal.kinematics import angular_velocity
from rigrunner_bearings.signal.peaks import mean_peak, scatter_effect
from rigrunner_bearings.signal.sensor import difference_effects, gain
from rigrunner_bearings.signal.swings import with_swings

api_version = 1


class LoadCellSettings(Settings):
    """Quantities with their units, bounds and lists."""

    rate: Annotated[Frequency, Field(gt=0)] = 1000.0
    full_scale: Force
    wait: Duration = 0.1
    limits: ListOf[Force] = ()
    offset: AnyQuantity = parse_quantity("0 N", "force")
    inverted: YesNo = False


class BackEndError(Exception):
    """What the maker's library raises."""


class LoadCell(Driver):
    """Streams and reads; its back end's errors are mapped."""

    errors = {BackEndError: DeviceLostError, ValueError: DeviceRejectedError}
    non_blocking = True

    def __init__(self, settings: LoadCellSettings, context: DeviceContext) -> None:
        drive = DriveInfo("preload", "N", "Preload", 0.0, settings.full_scale, tolerance=1.0)
        super().__init__(context, [ChannelInfo("load", "N", "Load")], [drive])
        self.settings = settings
        self._preload_n = 0.0

    @property
    def sample_rate_hz(self) -> float:
        """Samples per second."""
        return self.settings.rate

    def open(self, timeout_s: float) -> Identity:
        """Say who answers."""
        if timeout_s <= 0:
            raise DeviceTimeoutError("no time at all")
        return Identity("A stranger", "load cell", "7")

    def get(self, channel: str) -> float:
        """Return the load or the preload."""
        return self.exchange(f"read {channel}", lambda: self._preload_n)

    def put(self, drive: str, value: float) -> None:
        """Set the preload."""
        self._preload_n = value

    def actual(self, drive: str) -> float:
        """Return where the drive stands."""
        return self._preload_n

    def stream(
        self, channels: Sequence[str], duration_s: float, stop: StopToken
    ) -> Iterator[Block]:
        """Yield blocks of a tenth of a second."""
        samples, step = round(duration_s * self.sample_rate_hz), round(0.1 * self.sample_rate_hz)
        for first in range(0, samples, step):
            if stop.is_set():
                return
            values: Array = np.full(min(step, samples - first), self._preload_n)
            now_s = self.clock.monotonic_s()
            yield Block(self.sample_rate_hz, first, now_s, dict.fromkeys(channels, values))


class SimulatedScale:
    """Answers as the scale does."""

    def answer(self, request: str) -> str:
        """Return the weight in newtons."""
        return "Stranger,scale,1,1" if request == "*IDN?" else "1.5"


class Scale(LineDriver):
    """Talks in lines."""

    channels = (ChannelInfo("load", "N", "Load"),)
    simulator = SimulatedScale

    def get(self, channel: str) -> float:
        """Return the load."""
        return float(self.ask("W"))


class DelayedSettings(WrapperSettings):
    """Another device, with a delay."""

    delay: Duration = 1.0


def make_delayed(settings: DelayedSettings, context: DeviceContext) -> Device:
    """Return the device that is wrapped."""
    clock: Clock = context.clock
    clock.sleep(0.0)
    return context.make(settings.plugin, settings.settings)


def abilities(device: Device) -> list[str]:
    """Return what a device can do."""
    found = []
    if isinstance(device, Readable):
        found.append(f"{len(device.read([]))} read")
    if isinstance(device, Approaching):
        found.append(f"{device.arrived('load')}")
    if isinstance(device, Settable):
        found.append(f"{device.read_back('load'):g}")
    if isinstance(device, Streaming):
        found.append(f"{device.sample_rate_hz:g} Hz")
    if isinstance(device, Pausable):
        device.pause()
    return found


@dataclass(frozen=True, eq=False)
class Constant:
    """The mean of the points; satisfies Curve and Spreading."""

    names: tuple[str, ...]
    units: tuple[str, ...]
    coefficients: Array
    covariance: Array
    dof: float
    residuals: Array
    residual_s: float
    r_squared: float
    valid_x: tuple[float, float]
    formula: str = "T = c0"

    def predict(self, x: Array) -> tuple[Array, Array]:
        """Return the mean and its standard uncertainty."""
        if x.min() < self.valid_x[0] or x.max() > self.valid_x[1]:
            raise DataError("outside", hint="stay within")
        u = np.sqrt(np.diag(self.covariance))
        return np.full(len(x), self.coefficients[0]), np.full(len(x), u[0])

    def spread(self, x: Array) -> Array:
        """Return the standard uncertainty as the only direction."""
        return self.predict(x)[1][:, None]


def mean_of(points: Points) -> Constant:
    """Return the mean of y."""
    n = len(points.y)
    if n < 2:
        raise DataError(f"{n} points cannot give 1 coefficient with its uncertainty")
    s = float(points.y.std(ddof=1))
    return Constant(
        names=("c0",),
        units=(points.y_unit,),
        coefficients=np.array([points.y.mean()]),
        covariance=np.array([[s**2 / n]]),
        dof=n - 1,
        residuals=points.y - points.y.mean(),
        residual_s=s,
        r_squared=0.0,
        valid_x=(float(points.x.min()), float(points.x.max())),
    )


def reject_the_greatest(values: Array) -> list[Rejection]:
    """Return one rejection, or none of no values."""
    if not len(values):
        return []
    worst = int(values.argmax())
    return [Rejection(worst, float(values[worst]), "stranger_rule", 1.0, 0.0)]


@dataclass(frozen=True)
class Half:
    """A compensation that takes half of the raw torque for the rig's."""

    settings: NoSettings

    def __call__(self, sweep: Sweep) -> Compensation:
        """Return a point for each loaded one."""
        rig: RigDescription = sweep.rig
        points = tuple(self._point(point, sweep.instrument, rig) for point in sweep.loaded)
        check = Check("halves", ok=True, text="it halves", value=0.5, unit="1")
        learned = {"half": Estimate(0.5, 0.1, unit="1")}
        return Compensation("half the torque", points, parameters=learned, checks=(check,))

    def _point(
        self, point: PeakPoint, instrument: Instrument, rig: RigDescription
    ) -> CompensatedPoint:
        raw = mean_peak(point)
        kept: Mask = point.peak_kept
        own = Effect(Input("half", 0.0, 0.1, 9.0, Distribution.T), float(kept.mean()))
        effects = (scatter_effect("scatter", raw), own, *difference_effects(instrument, runs=1))
        scales = (gain(instrument), limited("load", rig.load_tolerance, "1"))
        model: MeasurementModel = model_of(raw.value / 2, effects, scales=scales)
        return compensated_point(
            model,
            set_frequency_hz=point.set_frequency_hz,
            frequency_hz=point.frequency_hz.value,
            raw_nm=raw.value,
        )


def swing_speeds(sweep: Sweep, rig: RigDescription) -> list[Array]:
    """Return the angular velocity over one swing of every loaded point."""
    swings: tuple[SwingPoint, ...] = with_swings(sweep).loaded
    return [
        angular_velocity(each.angle_rad, each.set_frequency_hz, rig.eccentric_ratio)
        for each in swings
    ]


class OneNumber:
    """Reads files that hold one number."""

    def read(
        self, path: Path, columns: Mapping[str, int | str], group: str
    ) -> Mapping[str, Column]:
        """Return that number for each column."""
        if group:
            raise NotInFileError("no groups", location=Location(str(path), 1))
        values = np.array([float(path.read_text(encoding="utf-8"))])
        return {wanted: Column(values, unit="N") for wanted in columns}


def as_text(report: ReportInput) -> bytes:
    """Return the verdict."""
    decision = report.result.decision
    verdict: Verdict | None = decision.verdict if decision else None
    run: RunData = report.result.run
    recordings: tuple[Recording, ...] = run.recordings
    return f"{verdict}: {len(recordings)}".encode()


def certificate_as_text(certificate: CertificateInput) -> bytes:
    """Return nothing of it."""
    return repr(type(certificate)).encode()


class Counting:
    """Counts events."""

    def __init__(self) -> None:
        self.count = 0

    def __call__(self, event: Event) -> None:
        """Count one."""
        self.count += 1


def _fit(_: NoSettings) -> Fit:
    return mean_of


def _rule(_: NoSettings) -> OutlierRule:
    return reject_the_greatest


def _importer(_: NoSettings) -> Importer:
    return OneNumber()


def _report(_: NoSettings) -> Callable[[ReportInput], bytes]:
    return as_text


def _certificate(_: NoSettings) -> Callable[[CertificateInput], bytes]:
    raise MissingPackageError("needs a package", hint="pip install it")


def _study(_: NoSettings) -> Callable[[StudyInput], bytes]:
    return lambda study: f"{study.quantity} / {study.unit}".encode()


def _sink(_: NoSettings) -> EventSink:
    return Counting()


def kind_of_error(error: DeviceError) -> str:
    """Return in one word what went wrong."""
    return "absent" if isinstance(error, DeviceNotFoundError) else error.message


# what is assigned here, mypy compares with the contract
CURVE: type[Curve] = Constant
SPREADING: type[Spreading] = Constant
ANSWERING: type[Answering] = SimulatedScale
METHOD: Callable[[NoSettings], CompensationMethod] = Half
NEWTON: Quantity = parse_quantity("1 N", "force")


@hookimpl
def rigrunner_devices() -> list[DeviceRecord]:
    """Three devices."""
    trial: dict[str, Any] = {"full_scale": "1 kN"}
    return [
        DeviceRecord(
            name="stranger_cell",
            help="A load cell.",
            settings=LoadCellSettings,
            factory=LoadCell,
            trial=trial,
        ),
        DeviceRecord(
            name="stranger_scale", help="A scale.", settings=LineSettings, factory=Scale, wired=True
        ),
        DeviceRecord(
            name="stranger_delay", help="A delay.", settings=DelayedSettings, factory=make_delayed
        ),
    ]


class Strict:
    """Passes what is within its limits by twice the expanded uncertainty."""

    words: Mapping[str, str] = {
        "en": "guard band w = 2 U of 95 %; what is not within the limit by w fails"
    }

    def __init__(self, settings: NoSettings) -> None:
        """Take no settings."""

    def __call__(self, limits: Limits, estimate: Estimate) -> Sequence[Zone]:
        """Return the one zone."""
        return [Zone(Verdict.PASS, 2 * expanded(estimate), "w = 2 U")]


@hookimpl
def rigrunner_decision_rules() -> list[DecisionRuleRecord]:
    """One decision rule."""
    return [DecisionRuleRecord(name="stranger_strict", help="Twice U.", factory=Strict)]


FIRST = ResultDefinition(name="first", text="the first voltage", unit="V")


class FirstVoltage:
    """Gives the first voltage; satisfies Analysis."""

    def __init__(self, settings: NoSettings) -> None:
        """Take no settings."""

    def __call__(self, run: RunData) -> Findings:
        """Return it; raise DataError where there is none."""
        for row in run.measurements:
            if "meter.voltage" in row.values:
                found = Estimate(row.values["meter.voltage"], 0.1, unit="V")
                return Findings(results=(MeasurementResult(of=FIRST, estimate=found),))
        raise DataError("meter.voltage was not measured")


@hookimpl
def rigrunner_analyses() -> list[AnalysisRecord]:
    """One analysis."""
    return [
        AnalysisRecord(
            name="stranger_first",
            help="The first voltage.",
            factory=FirstVoltage,
            yields=lambda _: (FIRST,),
            requires=lambda _: Requirements(
                channels=(NeededChannel(name="meter.voltage", key=()),)
            ),
            trial_units={"meter.voltage": "V"},
        )
    ]


@hookimpl
def rigrunner_fits() -> list[FitRecord]:
    """One fit."""
    return [FitRecord(name="stranger_fit", help="The mean.", factory=_fit)]


@hookimpl
def rigrunner_outlier_rules() -> list[OutlierRuleRecord]:
    """One rule."""
    return [OutlierRuleRecord(name="stranger_rule", help="The greatest.", factory=_rule)]


@hookimpl
def rigrunner_compensations() -> list[CompensationRecord]:
    """One compensation."""
    kind = MeasurandKind(Nature.LOAD_INDUCED, Condition.AT_REVERSAL)
    return [CompensationRecord(name="stranger_half", help="Half.", factory=Half, yields=kind)]


@hookimpl
def rigrunner_importers() -> list[ImporterRecord]:
    """One importer."""
    return [ImporterRecord(name="stranger_number", help="One number.", factory=_importer)]


@hookimpl
def rigrunner_report_formats() -> list[ReportFormatRecord]:
    """One report."""
    return [ReportFormatRecord(name="stranger_text", help="Text.", suffix=".txt", factory=_report)]


@hookimpl
def rigrunner_certificate_formats() -> list[CertificateFormatRecord]:
    """One form of certificates."""
    return [
        CertificateFormatRecord(
            name="stranger_text", help="Text.", suffix=".txt", factory=_certificate
        )
    ]


@hookimpl
def rigrunner_study_formats() -> list[StudyFormatRecord]:
    """One report on many runs."""
    return [StudyFormatRecord(name="stranger_text", help="Text.", suffix=".txt", factory=_study)]


@hookimpl
def rigrunner_event_sinks() -> list[EventSinkRecord]:
    """One listener."""
    return [EventSinkRecord(name="stranger_count", help="Counts.", factory=_sink)]


@hookimpl
def rigrunner_units() -> list[UnitRecord]:
    """One unit of a kind that is known, and one of its own."""
    hardness = UnitDefinition("StrH", "stranger hardness", "1", spellings=("strH",))
    return [
        UnitRecord(name="stranger_hardness", help="Hardness.", definition=hardness),
        UnitRecord(
            name="stranger_ounce",
            help="An ounce.",
            definition=UnitDefinition("stroz", "mass", "kg", 0.028349523125),
        ),
    ]
