from __future__ import annotations

import json
import shutil

import h5py
import pytest

from rigrunner.documents.verifying.run import verify_run
from rigrunner.registry import load_registry
from rigrunner.runfile.manifest import manifest_text


@pytest.fixture
def folder(quick, tmp_path):
    copy = tmp_path / quick.loaded.name
    shutil.copytree(quick.loaded, copy)
    (copy / "run.h5").chmod(0o644)
    return copy


def edited(folder, edit):
    with h5py.File(folder / "run.h5", "r+") as file:
        edit(file["entry"])
    return verify_run(folder, load_registry())


def reseal(entry):
    """Do what someone does who knows the layout: make the manifest fit what was changed."""
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


def test_a_run_matches(quick):
    verification = verify_run(quick.loaded, load_registry())
    assert verification.differences == []
    assert verification.matches
    assert "result recomputed from the raw samples" in verification.held
    assert "result.json" in verification.held


def test_a_zero_that_was_changed_is_found_in_the_file(folder):
    verification = edited(folder, lambda entry: entry["zeros/tester_torque"].__setitem__((), 0.5))
    assert any("/entry/zeros/tester_torque (zero)" in text for text in verification.differences)
    assert not verification.matches
    assert any("not recomputed" in text for text in verification.information)


@pytest.mark.thorough
def test_a_parameter_that_was_changed_and_sealed_anew_gives_other_numbers(folder):
    def edit(entry):
        entry["zeros/tester_torque"][()] += 0.5
        reseal(entry)

    verification = edited(folder, edit)
    assert "manifest of the run file" in verification.held
    assert any(text.startswith("result recomputed") for text in verification.differences)


def test_a_result_that_does_not_follow_from_the_samples_is_found(folder):
    def edit(entry):
        change_result(entry, '"verdict": "pass"', '"verdict": "fail"')
        reseal(entry)

    verification = edited(folder, edit)
    assert verification.differences == [
        f"{what}: verdict/verdict: 'fail' is recorded, 'pass' was derived"
        for what in ("result recomputed from the raw samples", "result.json")
    ]


def test_result_file_beside_the_run_is_held_to_it(folder):
    path = folder / "result.json"
    content = json.loads(path.read_text(encoding="utf-8"))
    content["headline"]["compensated"]["value"] += 1e-7
    path.write_text(json.dumps(content), encoding="utf-8")
    (difference,) = verify_run(folder, load_registry()).differences
    assert difference == "result.json: it is not the result that is in the run file"
    path.write_text("{", encoding="utf-8")
    (difference,) = verify_run(folder, load_registry()).differences
    assert "result.json cannot be read" in difference


def test_other_versions_are_told_and_decide_nothing(folder):
    def edit(entry):
        entry["provenance/numpy"].attrs["text"] = "1.0"
        reseal(entry)

    verification = edited(folder, edit)
    assert verification.matches
    assert any(t.startswith("numpy: 1.0 when it was recorded") for t in verification.information)


def test_file_of_the_first_format_says_what_it_cannot_show(folder):
    def edit(entry):
        del entry["manifest"], entry["no_load/manifest"]
        entry.file.attrs.modify("rigrunner_format", 1)

    verification = edited(folder, edit)
    assert verification.matches
    texts = verification.information
    assert any("without a manifest, by an older version" in text for text in texts)
