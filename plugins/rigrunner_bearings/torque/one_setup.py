"""Whether two runs can be taken from each other: one transducer and filter, one swing, no load.

What the difference of a loaded and a no-load run is worth rests on this. A gain that both share
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
    """Yield in words what of a no-load run's set-up is not as the loaded run needs it.

    Transducers by channel; one that only one of the runs has is not compared.
    """
    for each in transducers:
        if each.channel not in needed:
            continue
        own = needed[each.channel]
        for what, theirs, ours in (
            ("torque transducer", each.serial, own.serial),
            ("transducer's certificate", each.certificate, own.certificate),
            ("full scale", f"{each.full_scale:g} N·m", f"{own.full_scale:g} N·m"),
            ("low-pass filter", _filter(each), _filter(own)),
        ):
            if theirs != ours:
                yield f"its {what} is '{theirs}', but '{ours}' is needed"
    for what in ("eccentric", "centre_distance"):
        lengths_m = (getattr(rig, what), getattr(needed_rig, what))
        theirs, ours = (
            "not stated" if each is None else f"{1000 * each:.6g} mm" for each in lengths_m
        )
        if theirs != ours:
            yield f"its {what.replace('_', ' ')} is {theirs}, but {ours} is needed"


def setup_check(run: RunData, no_load: RunData) -> Check:
    """Check that the no-load run was made with the transducer, filter and swing of the run."""
    theirs, ours = (torque_instruments(each.instruments.values()) for each in (no_load, run))
    differences = setup_differences(rig_of(no_load), theirs.values(), rig_of(run), ours)
    found = [(1.0, f"of the no-load run, {words}") for words in differences]
    return ONE_SETUP.check(found or [(0.0, "")])


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
    left = [(abs(point.load_n) / least, point) for point in no_load]
    check = UNLOADED.check(
        (100 * share, f"{point.recording} was made under {point.load_n:.4g} N")
        for share, point in left
    )
    most = max(share for share, _ in left)
    return replace(
        check,
        biases=tuple(
            Bias(
                f"{each.frequency_hz:.4g} Hz",
                -most * each.torque.value,
                most * abs(each.torque.value) / 2,
            )
            for each in compensated
        ),
    )


def _filter(instrument: Instrument) -> str:
    return "none" if instrument.low_pass is None else instrument.low_pass.described
