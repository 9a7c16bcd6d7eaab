"""The readers of files that come from outside, each with some valid files to start from.

A target takes a file with any content, and either reads it or raises a RigrunnerError.
"""

from __future__ import annotations

import shutil
from contextlib import suppress
from datetime import UTC, datetime
from functools import cache
from io import BytesIO
from itertools import product
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING
from zipfile import ZipFile

import h5py
import numpy as np
from lab_targets import LAB_TARGETS
from nptdms import ChannelObject, GroupObject, RootObject, TdmsWriter
from scipy.io import savemat
from target import Target

from helpers_certificate import issue, make_letterhead
from helpers_workflow import run
from rigrunner.api.data import Block
from rigrunner.api.errors import DeviceTimeoutError
from rigrunner.api.events import Scanned, StepStarted
from rigrunner.api.hooks import NoSettings
from rigrunner.certificate.letterhead import read_letterhead
from rigrunner.certificate.numbers import Numbers
from rigrunner.certificate.order import read_order
from rigrunner.documents.packing.contents import LISTING
from rigrunner.documents.packing.pack import pack
from rigrunner.documents.packing.unpack import unpack
from rigrunner.procedure import load_procedure
from rigrunner.proof.contents import content_in
from rigrunner.proof.keys import new_key, read_private_key, read_public_keys
from rigrunner.proof.seal import check_seal
from rigrunner.proof.signature import check_signature, parse_signature, sign_files, signature_json
from rigrunner.run.approval import ApprovalFile
from rigrunner.run.inputs import read_answers
from rigrunner.run.locate import find_procedure, find_station, shipped_folder
from rigrunner.runfile import RunWriter, read, read_info, read_truth
from rigrunner.runfile.codec import block_bytes, event_record, header_bytes
from rigrunner.runfile.folder import RunFolder
from rigrunner.runfile.journal import JournalWriter, Kind, read_records
from rigrunner.station import load_station
from rigrunner.tape import TapedFile, TapedPlugin, TapeManifest
from rigrunner.tape.file import TapeFile
from rigrunner.tape.manifest import read_manifest
from rigrunner.tape.recording import RecordingWire, Trouble
from rigrunner.tools.importing.mapping import load_mapping
from rigrunner.tools.labfolder import TEMPLATE
from rigrunner.yamlfile import read as read_yaml
from rigrunner.yamlfile import validate
from rigrunner_plugins.devices.replay.manifest import load_manifest
from rigrunner_plugins.devices.replay.settings import ColumnSettings
from rigrunner_plugins.importers.csv_file import read_csv
from rigrunner_plugins.importers.hdf5_file import read_hdf5
from rigrunner_plugins.importers.lvm_file import LvmImporter
from rigrunner_plugins.importers.matlab_file import MatlabImporter
from rigrunner_plugins.importers.settings import LvmSettings, TableSettings
from rigrunner_plugins.importers.tdms_file import TdmsImporter
from unit.rigrunner_plugins.importers.helpers_importing import lvm_text, write_matlab_73
from unit.runfile.helpers_runfile import DOCUMENT, PLOT, header_of, recording, write_run

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigrunner.api.events import Event
    from rigrunner.procedure import Procedure

CHANNELS = {
    "angle": ColumnSettings(column="angle", unit="deg"),
    "torque": ColumnSettings(column="torque", unit="N·m"),
}
MANIFEST = """rigrunner: replay/1
recordings:
  - {file: a.csv, frequency: 10 Hz, load: 1000 N}
  - {file: b.csv, frequency: 20 Hz, load: 0 N, values: {torque: 1.5 N·m}}
"""
ANSWERS = "specimen: SN-0042\noperator: 'Zoë'\n"


def _shipped(pattern: str) -> list[bytes]:
    return [path.read_bytes() for path in sorted(shipped_folder().glob(pattern))]


def _procedure_seeds(_: Path) -> list[bytes]:
    """Return the shipped procedures that call no other, which would be missing beside them."""
    return [text for text in _shipped("*.yaml") if b"call:" not in text]


@cache
def _starting_torque() -> Procedure:
    return load_procedure(shipped_folder() / "starting_torque_1000n.yaml").model


def _answers(path: Path) -> object:
    return read_answers(path, _starting_torque())


def _csv(path: Path) -> object:
    return read_csv(path, {"angle": "angle", "torque": 2}, TableSettings())


def _csv_seeds(_: Path) -> list[bytes]:
    rows = "\n".join(f"{i / 7:.5f},{-i / 3:.4e}" for i in range(40))
    return [f"angle,torque\n{rows}\n".encode(), b"\xef\xbb\xbfangle,torque\r\n1,2\r\n"]


def _manifest(path: Path) -> object:
    for name in ("a.csv", "b.csv"):
        (path.parent / name).touch()
    return load_manifest(path.parent, path.name, CHANNELS)


def _hdf5(path: Path) -> object:
    return read_hdf5(path, {"angle": "angle", "torque": "torque"}, "/")


def _hdf5_seeds(folder: Path) -> list[bytes]:
    for name, filters in {
        "plain": {},
        "packed": {"compression": "gzip", "fletcher32": True},
    }.items():
        with h5py.File(folder / name, "w") as file:
            for channel in CHANNELS:
                file.create_dataset(channel, data=np.arange(300.0), **filters)
    return [(folder / "plain").read_bytes(), (folder / "packed").read_bytes()]


def _run(path: Path) -> object:
    return read_info(path), read(path), read_truth(path)


def _run_seeds(folder: Path) -> list[bytes]:
    write_run(folder / "no_load", [recording(samples=100)])
    partners = {"no_load": folder / "no_load", "before": folder / "no_load"}
    writer = write_run(folder / "run", [recording(samples=200), recording("b", samples=150)])
    with_partners = write_run(folder / "other", [recording(samples=100)])
    sealed = writer.seal(DOCUMENT, PLOT), with_partners.seal(DOCUMENT, PLOT, partners=partners)
    return [path.read_bytes() for path in sealed]


def _packed(path: Path) -> object:
    return unpack(path, _empty(path.parent / "runs"))


def _packed_seeds(folder: Path) -> list[bytes]:
    writer = write_run(folder / "run", [recording(samples=100)])
    writer.seal(DOCUMENT, PLOT)
    pack(folder / "run", folder / "run.zip")
    return [(folder / "run.zip").read_bytes()]


@cache
def _good_packed() -> bytes:
    with TemporaryDirectory() as folder:
        (packed,) = _packed_seeds(Path(folder))
    return packed


def _packing_list(path: Path) -> object:
    """Unpack a valid packed run with this file as its list of contents."""
    packed = path.parent / "packed.zip"
    with ZipFile(BytesIO(_good_packed())) as good, ZipFile(packed, "w") as changed:
        for entry in good.infolist():
            is_list = entry.filename == LISTING
            changed.writestr(entry, path.read_bytes() if is_list else good.read(entry))
    return _packed(packed)


def _packing_list_seeds(_: Path) -> list[bytes]:
    with ZipFile(BytesIO(_good_packed())) as good:
        return [good.read(LISTING)]


def _journal(path: Path) -> object:
    """Read an unsealed run with this file as its journal."""
    files = RunFolder(path.parent / "run")
    files.journal.mkdir(parents=True, exist_ok=True)
    shutil.copy(path, files.events)
    return read(files.path)


def _journal_seeds(folder: Path) -> list[bytes]:
    writer = write_run(folder / "run", [recording(samples=200)])
    return [RunFolder(writer.folder).events.read_bytes()]


RECORDS = (Kind.HEADER, Kind.EVENT, Kind.PACKED, Kind.TRUTH, Kind.ROW, Kind.PLAN)


def _record(path: Path) -> object:
    """Read a valid header, the start of a scan, and one record with a valid checksum."""
    kind, payload = path.read_bytes()[:1], path.read_bytes()[1:]
    files = RunFolder(path.parent / "run")
    files.journal.mkdir(parents=True, exist_ok=True)
    files.events.unlink(missing_ok=True)
    journal = JournalWriter(files.events)
    journal.append(Kind.HEADER, header_bytes(header_of()))
    for event in _scan(points=1):
        journal.append(*event_record(event))
    journal.append(RECORDS[kind[0] % len(RECORDS)] if kind else Kind.EVENT, payload)
    journal.close()
    return read(files.path), read_truth(files.path)


def _record_seeds(folder: Path) -> list[bytes]:
    run_writer = write_run(folder / "run", [recording(samples=200)])
    records = [*read_records(RunFolder(run_writer.folder).events)]
    with RunWriter(folder / "scan", header_of()) as writer:
        for event, sink in product(_scan(points=2), writer.sinks):
            sink(event)
    records += read_records(RunFolder(folder / "scan").events)
    return [bytes([RECORDS.index(Kind(record.kind))]) + record.payload for record in records]


def _scan(points: int) -> Iterator[Event]:
    common = {"seq": 1, "monotonic_s": 0.5, "utc": "2026-03-01T12:00:00.000Z", "step": "main[0]"}
    yield StepStarted(**common, index=0, action="scan", text="Scan", units={"tester.load": "N"})
    for point in range(points):
        setpoints, values = {"tester.load": 10.0}, {"tester.torque": 0.5}
        yield Scanned(**common, point=point, measurement="m", setpoints=setpoints, values=values)


def _block(path: Path) -> object:
    """Read an unsealed run with this block among its samples, with a valid checksum."""
    files = RunFolder(path.parent / "run")
    if not files.path.exists():
        write_run(files.path, [recording(samples=200)])
        files.part(1).unlink()
    files.samples(1).unlink(missing_ok=True)
    journal = JournalWriter(files.samples(1))
    for payload in (_good_block(), (path.read_bytes(),), _good_block()):
        journal.append(Kind.BLOCK, *payload)
    journal.close()
    return read(files.path)


def _good_block() -> tuple[bytes | memoryview, ...]:
    channels = {"tester.torque": np.arange(5.0), "tester.angle": np.ones(5)}
    return block_bytes("001_10Hz", Block(100.0, 0, 0.0, channels))


def _block_seeds(_: Path) -> list[bytes]:
    return [b"".join(_good_block())]


def _tape(path: Path) -> object:
    """Read every exchange of a tape."""
    tape = TapeFile(path)
    try:
        return [tape.entry(seq) for seq in range(len(tape))]
    finally:
        tape.close()


def _tape_seeds(folder: Path) -> list[bytes]:
    trouble = Trouble()
    wire = RecordingWire(folder / "tape", trouble)
    blocks = [
        {"torque": np.arange(9.0), "at": [0.25, float("nan")]},
        b"#15\x00\x01",
        "Zoë",
        None,
        7,
    ]
    for answer in blocks:
        wire.exchange("fetch TRAC:DATA? 9", lambda answer=answer: answer)
    with suppress(DeviceTimeoutError):
        wire.exchange("query *IDN?", _times_out)
    wire.close()
    return [(folder / "tape").read_bytes()]


def _tape_manifest(path: Path) -> object:
    folder = _empty(path.parent / "tape")
    shutil.copy(path, folder / "tape.json")
    return read_manifest(folder)


def _tape_manifest_seeds(_: Path) -> list[bytes]:
    manifest = TapeManifest(
        program="0.1.0",
        began_utc=datetime(2026, 3, 1, 12, tzinfo=UTC),
        station=TapedFile(id="bench", sha256="0" * 64),
        devices={"tester": TapedPlugin(plugin="visa", provider="lab 1", settings_sha256="1" * 64)},
        inputs={"specimen": "SN-0042"},
    )
    return [manifest.model_dump_json(indent=2).encode()]


def _times_out() -> None:
    raise DeviceTimeoutError("no answer in 2 s", hint="is it on?")


def _approval(path: Path) -> object:
    return validate(ApprovalFile, read_yaml(path))


APPROVAL = (
    '{"rigrunner": "approval/1", "procedure": "SSPB-NLI", "approved": {"revision": "A",'
    f' "by": "Zoë", "utc": "2026-03-01", "sha256": "{"0" * 64}"}}, "earlier": []}}'
)
ORDER_FILE = (
    "rigrunner: order/1\ncustomer: Muster & Söhne\nreceived: 2026-03-01\n"
    "deviations: [Outer ring clamped with two screws.]\n"
    "opinions:\n  - {text: It runs in slowly., by: O. Pinion}\n"
)
TEXTS = "rigrunner: texts/1\ntexts:\n  title: Test report\n  page: '{page} of {pages}'\n"


def _letterhead(path: Path) -> object:
    """Read a letterhead of this file, with a logo beside it."""
    folder = _empty(path.parent / "letterhead")
    shutil.copy(TEMPLATE / "letterhead" / "logo.svg", folder)
    shutil.copy(path, folder / "letterhead.yaml")
    return read_letterhead(folder)


def _letterhead_texts(path: Path) -> object:
    """Read a valid letterhead with this file of texts."""
    folder = path.parent / "letterhead"
    if not folder.exists():
        shutil.copytree(TEMPLATE / "letterhead", folder)
        (folder / "texts").mkdir()
    shutil.copy(path, folder / "texts" / "de.yaml")
    return read_letterhead(folder)


def _letterhead_seeds(_: Path) -> list[bytes]:
    return [(TEMPLATE / "letterhead" / "letterhead.yaml").read_bytes()]


NUMBER = (
    '{"number": "RR-2026-0001", "amends": "RR-2026-0000", "folder": "issued",'
    f' "sha256": {{"RR-2026-0001.json": "{"0" * 64}"}}}}'
)


def _number(path: Path) -> object:
    """Look up a certificate number and its replacement in this file."""
    folder = _empty(path.parent / "numbers")
    for name in ("RR-2026-0001.json", "RR-2026-0001.issued.json"):
        shutil.copy(path, folder / name)
    numbers = Numbers(path.parent, "RR")
    return numbers.digests_of("RR-2026-0001"), numbers.replaced_by("RR-2026-0000")


def _empty(folder: Path) -> Path:
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    return folder


def _certificate(path: Path) -> object:
    content = path.read_bytes()
    certificate = content_in(content, path.suffix, path.name)
    return certificate, check_seal(content, path.suffix)


@cache
def _issued() -> dict[str, bytes]:
    """Return the forms of a certificate on a demo run, by suffix."""
    with TemporaryDirectory() as name:
        folder = Path(name)
        station = find_station("simulated_bench")
        finished = run(find_procedure("no_load_breakaway"), folder / "runs", station=station)
        letterhead = make_letterhead(folder / "letterhead")
        issued = issue(finished.folder, letterhead, folder / "issued")
        return {path.suffix: path.read_bytes() for path in issued.files}


def _signature(path: Path) -> object:
    return check_signature(parse_signature(path.read_bytes(), path.name))


def _private_key(path: Path) -> object:
    path.chmod(0o600)  # other modes are refused
    return read_private_key(path)


def _signature_seeds(folder: Path) -> list[bytes]:
    new_key(folder / "lab.key")
    key = read_private_key(folder / "lab.key")
    files = {"C-1.json": b"{}", "C-1.html": b"<p>"}
    return [signature_json(sign_files(files, key, "Zoë", "2026-03-01T12:00:00.000Z")).encode()]


def _key_seeds(folder: Path) -> list[bytes]:
    return [new_key(folder / "lab.key").read_bytes()]


def _private_key_seeds(folder: Path) -> list[bytes]:
    new_key(folder / "lab.key")
    return [(folder / "lab.key").read_bytes()]


COLUMNS = {"angle": "Angle", "torque": "Torque"}
IMPORT = """rigrunner: import/1
procedure: starting_torque_1000n
station: simulated
format: {csv: {delimiter: ";"}}
program: Old.vi 3
by: Zoë
started: 2026-03-02T09:15:00+01:00
sampling: {time: {column: 1, unit: ms}}
channels: {tester.torque: {column: Torque, unit: mN·m, file_says: Volts}}
zeros: {tester.torque: {file: rest.csv, to: 3 s}}
conditions: {tester.load: {column: Load, unit: kN}, tester.temperature: 23 °C}
recordings:
  - {file: a.csv, group: "1", from: 1 s, set_points: {tester.frequency: 5 Hz}}
"""


def _lvm(path: Path) -> object:
    return LvmImporter(LvmSettings()).read(path, COLUMNS, "")


def _lvm_seeds(_: Path) -> list[bytes]:
    columns = {"Angle": [0.5, -1.25, 3e-7], "Torque": [1.0, 2.0, 3.0]}
    forms = [{"x": "No"}, {"x": "Multi", "sep": ","}, {"x": "One", "mark": ","}]
    return [lvm_text([columns], **form).encode() for form in forms]


def _tdms(path: Path) -> object:
    return TdmsImporter(NoSettings()).read(path, COLUMNS, "")


def _tdms_seeds(folder: Path) -> list[bytes]:
    wave = {"wf_increment": 1e-4, "unit_string": "Nm", "wf_start_offset": 0.0}
    with TdmsWriter(folder / "a.tdms") as writer:
        for _ in range(2):
            channels = [
                ChannelObject("r", name, np.arange(20.0), properties=wave)
                for name in COLUMNS.values()
            ]
            writer.write_segment([RootObject(), GroupObject("r"), *channels])
    return [(folder / "a.tdms").read_bytes()]


def _matlab(path: Path) -> object:
    return MatlabImporter(NoSettings()).read(path, {"angle": "s.Angle", "torque": "data(:,2)"}, "")


def _matlab_seeds(folder: Path) -> list[bytes]:
    content = {"s": {"Angle": np.arange(20.0)[:, None]}, "data": np.ones((20, 2))}
    write_matlab_73(folder / "73.mat", content)
    files = [(folder / "73.mat").read_bytes()]
    for compress in (False, True):
        savemat(folder / "5.mat", content, do_compression=compress)
        files.append((folder / "5.mat").read_bytes())
    return files


TARGETS = (
    Target("procedure", ".yaml", _procedure_seeds, load_procedure),
    Target("station", ".yaml", lambda _: _shipped("stations/*.yaml"), load_station),
    Target("answers", ".yaml", lambda _: [ANSWERS.encode()], _answers),
    Target("replay manifest", ".yaml", lambda _: [MANIFEST.encode()], _manifest),
    Target("replay csv", ".csv", _csv_seeds, _csv),
    Target("replay hdf5", ".h5", _hdf5_seeds, _hdf5),
    Target("mapping", ".yaml", lambda _: [IMPORT.encode()], load_mapping),
    Target("lvm", ".lvm", _lvm_seeds, _lvm),
    Target("tdms", ".tdms", _tdms_seeds, _tdms),
    Target("matlab", ".mat", _matlab_seeds, _matlab),
    Target("run file", ".h5", _run_seeds, _run),
    Target("packed run", ".zip", _packed_seeds, _packed),
    Target("list of a packed run", ".json", _packing_list_seeds, _packing_list),
    Target("journal", ".journal", _journal_seeds, _journal),
    Target("journal record", ".record", _record_seeds, _record),
    Target("journal block", ".block", _block_seeds, _block),
    Target("tape", ".jsonl", _tape_seeds, _tape),
    Target("tape manifest", ".json", _tape_manifest_seeds, _tape_manifest),
    Target("approval", ".json", lambda _: [APPROVAL.encode()], _approval),
    Target("order", ".yaml", lambda _: [ORDER_FILE.encode()], read_order),
    Target("letterhead", ".yaml", _letterhead_seeds, _letterhead),
    Target("letterhead texts", ".yaml", lambda _: [TEXTS.encode()], _letterhead_texts),
    Target("certificate number", ".json", lambda _: [NUMBER.encode()], _number),
    Target("certificate", ".json", lambda _: [_issued()[".json"]], _certificate),
    Target("certificate page", ".html", lambda _: [_issued()[".html"]], _certificate),
    Target("signature", ".sig", _signature_seeds, _signature),
    Target("public key", ".pub", _key_seeds, read_public_keys),
    Target("private key", ".key", _private_key_seeds, _private_key),
    *LAB_TARGETS,
)
