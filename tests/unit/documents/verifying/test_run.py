from __future__ import annotations

import json
import shutil

import h5py
import pytest

from rigrunner.api.errors import DataError
from rigrunner.documents.verifying import run
from rigrunner.documents.verifying.run import verify_run, versions
from rigrunner.registry import load_registry
from rigrunner.runfile.manifest import manifest_text


@pytest.fixture
def folder(quick, tmp_path):
    copy = tmp_path / quick.loaded.name
    shutil.copytree(quick.loaded, copy)
    (copy / "run.h5").chmod(0o644)
    return copy


def verify(folder, edit):
    with h5py.File(folder / "run.h5", "r+") as file:
        edit(file["entry"])
    return verify_run(folder, load_registry())


def reseal(entry):
    """Recompute the manifest after a change, as a forger who knows the layout would."""
    text = manifest_text(entry).encode()
    del entry["manifest"]
    entry.create_dataset("manifest", data=list(text), dtype="u1")


def change_result(entry, old, new):
    text = bytes(entry["analysis/result"][()]).decode()
    assert old in text
    del entry["analysis/result"]
    entry["analysis"].create_dataset(
        "result", data=list(text.replace(old, new, 1).encode()), dtype="u1"
    )


def test_unchanged_run_matches(quick):
    verification = verify_run(quick.loaded, load_registry())
    assert verification.differences == []
    assert verification.matches
    assert "result recomputed from the raw samples" in verification.held
    assert "result.json" in verification.held


def test_changed_zero_is_located_in_the_file(folder):
    verification = verify(folder, lambda entry: entry["zeros/tester_torque"].__setitem__((), 0.5))
    assert any("/entry/zeros/tester_torque (zero)" in text for text in verification.differences)
    assert not verification.matches
    assert any("not recomputed" in text for text in verification.information)


def test_result_that_cannot_be_derived_is_a_difference(quick, monkeypatch):
    def fail(*_):
        raise DataError("no fit converges")

    monkeypatch.setattr(run, "refuse_crashing", lambda _path: None)
    monkeypatch.setattr(run, "analyse_stored", fail)
    verification = verify_run(quick.loaded, load_registry())
    assert verification.differences == [
        "result recomputed from the raw samples: it cannot be derived: no fit converges"
    ]


@pytest.mark.thorough
def test_changed_and_resealed_parameter_gives_other_numbers(folder):
    def edit(entry):
        entry["zeros/tester_torque"][()] += 0.5
        reseal(entry)

    verification = verify(folder, edit)
    assert "manifest of the run file" in verification.held
    assert any(text.startswith("result recomputed") for text in verification.differences)


def test_result_that_contradicts_the_samples_is_a_difference(folder):
    def edit(entry):
        change_result(entry, '"verdict": "pass"', '"verdict": "fail"')
        reseal(entry)

    verification = verify(folder, edit)
    assert verification.differences == [
        f"{part}: verdict/verdict: 'fail' is recorded, 'pass' was derived"
        for part in ("result recomputed from the raw samples", "result.json")
    ]


def test_result_file_is_compared_with_the_run_file(folder):
    path = folder / "result.json"
    content = json.loads(path.read_text(encoding="utf-8"))
    content["headline"]["compensated"]["value"] += 1e-7
    path.write_text(json.dumps(content), encoding="utf-8")
    (difference,) = verify_run(folder, load_registry()).differences
    assert difference == "result.json: it is not the result that is in the run file"
    path.write_text("{", encoding="utf-8")
    (difference,) = verify_run(folder, load_registry()).differences
    assert "result.json cannot be read" in difference


def test_other_package_versions_are_only_reported(folder):
    def edit(entry):
        entry["provenance/numpy"].attrs["text"] = "1.0"
        reseal(entry)

    verification = verify(folder, edit)
    assert verification.matches
    assert any(t.startswith("numpy: 1.0 when it was recorded") for t in verification.information)


def test_missing_manifest_of_the_first_format_is_only_reported(folder):
    def edit(entry):
        del entry["manifest"], entry["no_load/manifest"]
        entry.file.attrs.modify("rigrunner_format", 1)

    verification = verify(folder, edit)
    assert verification.matches
    texts = verification.information
    assert any("without a manifest, by an older version" in text for text in texts)


def test_only_recorded_versions_can_differ():
    now = {"numpy": "2.0", "scipy": "1.9", "h5py": "3.0"}
    then = {"numpy": "1.0", "scipy": "1.9"}
    assert list(versions(then, now, "was recorded")) == ["numpy: 1.0 when it was recorded, 2.0 now"]
