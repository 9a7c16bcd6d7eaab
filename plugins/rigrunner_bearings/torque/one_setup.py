"""Whether two runs can be taken from each other: one transducer and filter, one swing, no load.

The difference of a loaded and a no-load run depends on this. A gain that both share
scales their difference; two gains leave their own difference times the torque of the whole rig,
which is several times that of the bearing.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from rigrunner.api.analysis import Bias
from rigrunner.api.checks import Limit, skipped
from rigrunner_bearings.api.rig import rig_of, torque_instruments

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, Sequence

    from rigrunner.api import Check, Instrument, RunData
    from rigrunner_bearings.api.compensations import CompensatedPoint
    from rigrunner_bearings.api.points import PeakPoint
    from rigrunner_bearings.api.rig import RigDescription

ONE_SETUP = Limit(
    name="one set-up",
    good="both runs are of one transducer, as it was calibrated once, one filter and one swing",
    advice="repeat the no-load run on the rig as it is now",
    unit="1",
    upper=0.0,
    decisive=True,
)
UNLOADED = Limit(
    name="load of the no-load run",
    good="at most 1 % of the load was there in the no-load run",
    advice="take the load off, or its zero: friction under this load is taken for the rig's own",
    unit="%",
    upper=1.0,
)
LIMITS = (ONE_SETUP, UNLOADED)


def setup_differences(
    rig: RigDescription,
    transducers: Iterable[Instrument],
    needed_rig: RigDescription,
    needed: Mapping[str, Instrument],
) -> Iterator[str]:
    """Yield in words how a no-load run's set-up differs from that of the loaded run.

    Transducers by channel; one that only one of the runs has is not compared.
    """
    for transducer in transducers:
        if transducer.channel not in needed:
            continue
        counterpart = needed[transducer.channel]
        for what, theirs, ours in (
            ("torque transducer", transducer.serial, counterpart.serial),
            ("transducer's certificate", transducer.certificate, counterpart.certificate),
            ("full scale", f"{transducer.full_scale:g} N·m", f"{counterpart.full_scale:g} N·m"),
            ("low-pass filter", _filter(transducer), _filter(counterpart)),
        ):
            if theirs != ours:
                yield f"its {what} is '{theirs}', but '{ours}' is needed"
    for what in ("eccentric", "centre_distance"):
        lengths_m = (getattr(rig, what), getattr(needed_rig, what))
        theirs, ours = (
            "not stated" if length_m is None else f"{1000 * length_m:.6g} mm"
            for length_m in lengths_m
        )
        if theirs != ours:
            yield f"its {what.replace('_', ' ')} is {theirs}, but {ours} is needed"


def setup_check(run: RunData, no_load: RunData) -> Check:
    """Check that the no-load run was made with the transducer, filter and swing of the run."""
    theirs, ours = (torque_instruments(one_run.instruments.values()) for one_run in (no_load, run))
    differences = setup_differences(rig_of(no_load), theirs.values(), rig_of(run), ours)
    failures = [(1.0, f"of the no-load run, {words}") for words in differences]
    return ONE_SETUP.check(failures or [(0.0, "")])


def unloaded_check(
    loaded: Iterable[PeakPoint],
    no_load: Iterable[PeakPoint],
    compensated: Sequence[CompensatedPoint],
) -> Check:
    """Check that next to nothing of the load was read while the no-load run was recorded.

    The bearing's friction under what was left is missing in the result: by Coulomb's law as much of
    it as was left of the load, which holds to a half of that.
    """
    least = min((point.load_n for point in loaded), default=0.0)
    if least <= 0:
        return skipped(UNLOADED.name, "the run has no load")
    shares = [(abs(point.load_n) / least, point) for point in no_load]
    check = UNLOADED.check(
        (100 * share, f"{point.recording} was made under {point.load_n:.4g} N")
        for share, point in shares
    )
    most = max(share for share, _ in shares)
    return replace(
        check,
        biases=tuple(
            Bias(
                f"{point.frequency_hz:.4g} Hz",
                -most * point.torque.value,
                most * abs(point.torque.value) / 2,
            )
            for point in compensated
        ),
    )


def _filter(instrument: Instrument) -> str:
    return "none" if instrument.low_pass is None else instrument.low_pass.described
