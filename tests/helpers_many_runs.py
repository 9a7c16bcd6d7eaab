"""Very many run folders, made quickly: copies of one sealed run with other facts.

Each has its own id, specimen, lot, rig, time and torque, and a manifest that fits: only what is
changed is digested anew, and it has the same length as before, so that files are edited in place.
"""

from __future__ import annotations

import json
import shutil
from datetime import UTC, datetime, timedelta
from typing import TYPE_CHECKING

import h5py
import numpy as np

from helpers_runfile import header_of, recording, write_run
from rigrunner.runfile import seal
from rigrunner.runfile.manifest import MANIFEST, object_digest

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

START = datetime(2020, 1, 1, tzinfo=UTC)
RIGS, LOTS, TYPES = 10, 200, 5
_SPARE = "spare"
"""In the template's result: numbers of other runs may have more digits."""


def template(folder: Path, document: dict) -> Path:
    """Seal a run of short recordings with a result, to be copied."""
    folder.mkdir()
    names = [each["recording"] for each in document["points"]]
    recordings = [recording(name, samples=200, seed=number) for number, name in enumerate(names, 1)]
    inputs = {"specimen": "SN-000000", "type": "GE-0", "lot": "L-000", "operator": "Ann"}
    write_run(folder, recordings, header=header_of("run-000000", inputs=inputs, station_id="rig-0"))
    seal(folder, {**document, _SPARE: " " * 2000})
    return folder


def make_many(root: Path, count: int, source: Path) -> Iterator[Path]:
    """Make run folders by the month; yield each. Torques are normal about 0.72 N·m."""
    with h5py.File(source / "run.h5") as file:
        document = json.loads(bytes(file["entry/analysis/result"][()]))
        del document[_SPARE]
        manifest = json.loads(bytes(file["entry"][MANIFEST][()]))
    rng = np.random.default_rng(1)
    for number in range(count):
        started = START + timedelta(minutes=13 * number)
        folder = root / f"{started:%Y-%m}" / f"{started:%Y%m%dT%H%M%SZ}_run-{number:06d}"
        folder.mkdir(parents=True)
        shutil.copyfile(source / "run.h5", folder / "run.h5")
        torque_nm = round(float(rng.normal(0.72, 0.05)), 6)
        _change(folder / "run.h5", number, started, _result(document, torque_nm), manifest)
        yield folder


def _result(document: dict, torque_nm: float) -> dict:
    shift = torque_nm - document["headline"]["compensated"]["value"]
    headline = {**document["headline"]["compensated"], "value": torque_nm}
    method = document["headline"]["method"]
    points = [
        {**each, "torque": {**each["torque"], "value": each["torque"]["value"] + shift}}
        for each in document["compensations"][method]["points"]
    ]
    compensations = document["compensations"]
    verdict = "pass" if torque_nm < 0.8 else "fail"
    return {
        **document,
        "headline": {**document["headline"], "compensated": headline},
        "decision": {**document["decision"], "verdict": verdict},
        "compensations": {**compensations, method: {**compensations[method], "points": points}},
    }


def _change(path: Path, number: int, started: datetime, document: dict, manifest: dict) -> None:
    items = dict(manifest["items"])
    with h5py.File(path, "r+") as file:
        entry = file["entry"]
        entry.attrs["run_id"] = f"run-{number:06d}"
        entry.attrs["station_id"] = f"rig-{number % RIGS}"
        entry.attrs["started_utc"] = f"{started:%Y-%m-%dT%H:%M:%S.000Z}"
        inputs = {
            "specimen": f"SN-{number:06d}",
            "lot": f"L-{number % LOTS:03d}",
            "type": f"GE-{number % TYPES}",
        }
        for name, text in inputs.items():
            entry[f"inputs/{name}"].attrs["text"] = text
        text = json.dumps(document, ensure_ascii=False).encode()
        result = entry["analysis/result"]
        result[...] = np.frombuffer(text.ljust(result.size), np.uint8)
        changed = [".", "analysis/result", *(f"inputs/{name}" for name in inputs)]
        for name in changed:
            item = entry if name == "." else entry[name]
            items[name] = {**items[name], "sha256": object_digest(item, name)}
        said = json.dumps({**manifest, "items": items}, sort_keys=True, separators=(",", ":"))
        entry[MANIFEST][...] = np.frombuffer(said.encode(), np.uint8)
