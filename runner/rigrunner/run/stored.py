"""Stored runs: their data for analyses, and their results."""

from __future__ import annotations

from dataclasses import dataclass, replace
from operator import itemgetter
from types import MappingProxyType
from typing import TYPE_CHECKING

from rigrunner.analysis.analyse import analyse
from rigrunner.analysis.named import findings_of, makers_of
from rigrunner.analysis.scrutiny import Scrutiny
from rigrunner.api.data import RunData, place_of
from rigrunner.api.errors import DataError, ExitCode, PluginError
from rigrunner.api.events import CONCLUDED, Outcome
from rigrunner.api.findings import MissingResult
from rigrunner.api.instruments import DEFAULT_QUANTITY
from rigrunner.api.progress import unseen
from rigrunner.api.verdict import Verdict
from rigrunner.procedure import kinds_of, parse_procedure
from rigrunner.run.interrupted import used_partners
from rigrunner.run.provenance import PROVIDERS
from rigrunner.runfile import read, zero_counts
from rigrunner.station import parse_station

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence
    from pathlib import Path

    from rigrunner.api.data import Measurement, Recording
    from rigrunner.api.findings import MeasurementResult
    from rigrunner.api.progress import Progress
    from rigrunner.api.quantity import Estimate
    from rigrunner.api.results import Result
    from rigrunner.procedure import Acceptance, Procedure
    from rigrunner.registry import Registry
    from rigrunner.runfile import StoredRun

    _Place = MeasurementResult | MissingResult


@dataclass(frozen=True, eq=False)
class OpenRun:
    """A stored run, with its data as analyses take it."""

    path: Path
    stored: StoredRun
    data: RunData


def open_run(path: Path) -> OpenRun:
    """Open a run folder, sealed or not, or a `run.h5`; raise DataError."""
    stored = read(path)
    return OpenRun(path, stored, run_data(stored))


def analyse_run(
    path: Path,
    registry: Registry,
    partners: Mapping[str, Path] = MappingProxyType({}),
    *,
    acceptance: Acceptance | None = None,
    progress: Progress = unseen,
) -> Result:
    """Analyse a stored run by its procedure; raise DataError.

    Partner runs are the given ones by name, or those embedded in the file. `acceptance` replaces
    that of the procedure. `progress` is called during a validation.
    """
    stored = with_partners(read(path), partners)
    return analyse_stored(stored, registry, acceptance=acceptance, progress=progress)


def with_partners(stored: StoredRun, partners: Mapping[str, Path]) -> StoredRun:
    """Return a run with these partner runs, by name, in place of those in its file."""
    read_again = {name: read(path) for name, path in partners.items()}
    return replace(stored, partners={**stored.partners, **read_again})


def as_it_is(procedure: Procedure) -> Procedure:
    """Return the procedure unchanged."""
    return procedure


def analyse_stored(
    stored: StoredRun,
    registry: Registry,
    *,
    acceptance: Acceptance | None = None,
    changes: Callable[[Procedure], Procedure] = as_it_is,
    progress: Progress = unseen,
) -> Result:
    """Analyse a run that was already read, as `analyse_run` does.

    `changes` returns the procedure to use in place of the stored one. Without an analysis the
    result has the recordings, and the limits of measured values.
    """
    text, name = stored.header.procedure_text, stored.header.procedure_id
    kinds = kinds_of(registry)
    procedure = changes(parse_procedure(text, name, kinds=kinds, stored=True).model)
    analyses, limits = procedure.analysis, procedure.acceptance
    if acceptance is not None:  # it may have been read without the plugins of the station
        limits = acceptance.as_read_by(kinds, analyses)
    run = run_data(stored)
    if not is_analysed(stored, procedure):
        analyses, limits, run = (), None, replace(run, partners={})
    try:
        return analyse(
            run,
            analyses,
            acceptance=limits,
            measurand=procedure.measurand,
            lookup=registry,
            progress=progress,
        )
    except PluginError as error:
        recorded = stored.header.provenance.get(PROVIDERS, "")
        names = [provider.partition(" ")[0] for provider in recorded.split(", ") if provider]
        available = {plugin.provider.name for plugin in registry.plugins}
        if missing := " and ".join(name for name in names if name not in available):
            what = f"the run was made with {missing}, which is not available"
            error.add_note(f"{what}: name its station by --station, or install it")
        raise


def verdict_code(result: Result | None) -> ExitCode:
    """Return the exit code of an analysed run: its verdict, if there is one.

    An interrupted run neither passes nor fails, even if its recordings are complete.
    """
    if result is None:
        return ExitCode.PASS
    if result.run.outcome not in CONCLUDED:
        return ExitCode.UNDECIDED
    codes = {None: ExitCode.PASS, Verdict.PASS: ExitCode.PASS, Verdict.FAIL: ExitCode.FAIL}
    return codes.get(result.verdict, ExitCode.UNDECIDED)


def result_by_now(folder: Path, procedure: Procedure, registry: Registry, name: str) -> Estimate:
    """Return a named result from the data of a running run, at the place measured last.

    Raises DataError for none.
    """
    makers = makers_of(name, procedure.analysis, registry)
    if not makers:
        raise DataError(f"no analysis names the result '{name}'")
    stored = read(folder)
    run = run_data(with_partners(stored, used_partners(stored.header)))
    findings = findings_of(run, makers, Scrutiny(registry))
    results = [result for part in findings for result in part.results if result.name == name]
    missing = [result for part in findings for result in part.missing if result.name == name]
    places: list[_Place] = [*results, *missing]
    if not places:
        raise DataError(f"there is no result '{name}' yet")
    latest = _measured_last(run, places)
    if isinstance(latest, MissingResult):
        raise DataError(latest.sentence.rstrip("."))
    return latest.estimate


def _measured_last(run: RunData, places: Sequence[_Place]) -> _Place:
    """Return the result at the place measured last, of those that have a result."""
    times: list[tuple[str, Recording | Measurement]] = [
        *((recording.started_utc, recording) for recording in run.recordings),
        *((row.utc, row) for row in run.measurements),
    ]
    for _, part in sorted(times, key=itemgetter(0), reverse=True):
        usual = {name: value.usual for name, value in place_of(part).items()}
        for place in places:
            if all(usual.get(name) == value.usual for name, value in place.coordinates.items()):
                return place
    return places[-1]


def is_analysed(stored: StoredRun, procedure: Procedure) -> bool:
    """Return whether the recordings of a run are analysed, besides its limits of measured values.

    The recordings of a run that stopped at a limit are incomplete.
    """
    return bool(procedure.analysis) and stored.info.outcome != Outcome.STOPPED_AT_LIMIT


def run_data(stored: StoredRun) -> RunData:
    """Return the data of a stored run for analyses."""
    header, info = stored.header, stored.info
    station = parse_station(header.station_text, header.station_id, stored=True).model
    name = header.inputs.get("operator")
    return RunData(
        run_id=header.run_id,
        procedure_id=header.procedure_id,
        procedure_revision=header.procedure_revision,
        procedure_title=header.procedure_title,
        station_id=header.station_id,
        started_utc=header.started_utc,
        ended_utc=info.ended_utc,
        outcome=info.outcome,
        inputs=header.inputs,
        rig_keys=station.rig,
        instruments={
            instrument.channel: instrument
            for instrument in sorted(
                station.instruments, key=lambda instrument: instrument.quantity != DEFAULT_QUANTITY
            )
        },
        people=header.people or ({"operator": name} if name else {}),
        approval=header.approval,
        imported=header.imported,
        zeros=stored.zeros,
        recording_zeros=stored.recording_zeros,
        zero_counts=zero_counts(stored.outline),
        recordings=stored.recordings,
        digest=stored.digest,
        measurements=stored.measurements,
        partners={name: run_data(partner) for name, partner in stored.partners.items()},
    )
