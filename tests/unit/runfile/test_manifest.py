from __future__ import annotations

import hashlib
import json
import random
from pathlib import Path

import h5py
import numpy as np
import pytest

from helpers_thorough import examples
from rigrunner.api.errors import DataError
from rigrunner.runfile import file_differences, read, read_info, seal
from rigrunner.runfile.manifest import differences, object_digest, stored_items
from unit.runfile.helpers_runfile import DOCUMENT, PLOT, TWO, recording, write_run


@pytest.fixture(scope="module")
def sealed(tmp_path_factory):
    folder = tmp_path_factory.mktemp("runs")
    write_run(folder / "no_load", TWO[:1]).seal({"no": "load"})
    return write_run(folder / "run", TWO).seal(
        DOCUMENT, PLOT, partners={"no_load": folder / "no_load"}
    )


@pytest.fixture
def copy(sealed, tmp_path):
    path = tmp_path / "run.h5"
    path.write_bytes(sealed.read_bytes())
    return path


def edited(path, edit):
    with h5py.File(path, "r+") as file:
        edit(file)
    return path


def test_sealed_run_has_no_differences(sealed):
    assert file_differences(sealed) == []


def test_manifest_lists_every_object_but_itself(sealed):
    with h5py.File(sealed) as file:
        names = {"/", "."}
        file["entry"].visit(names.add)
        document = json.loads(bytes(file["entry/manifest"][()]))
    assert set(document["items"]) == names - {"manifest"}
    kinds = {path: item["kind"] for path, item in document["items"].items()}
    assert kinds["recordings/_001_10Hz/tester_torque"] == "recording"
    assert kinds["zeros/tester_torque"] == "zero"
    assert kinds["events/json"] == "event list"
    assert kinds["verification/_001_10Hz"] == "truth"
    assert kinds["texts/station_text"] == "parameters"
    assert kinds["analysis/result"] == "result"
    assert kinds["no_load/zeros"] == "no-load run"


def test_object_digest_matches_its_description(tmp_path):
    """Computed here from the description in docs/reference/run-file.md, by hand."""
    with h5py.File(tmp_path / "x.h5", "w") as file:
        item = file.create_dataset("x", data=np.array([1.0, 2.0]))
        item.attrs["units"] = "N·m"
        item.attrs["column"] = np.int64(3)
        data = hashlib.sha256(bytes.fromhex("000000000000f03f0000000000000040")).hexdigest()
        text = (
            '{"attributes":{"column":{"data":"0300000000000000","dtype":"<i8","shape":[]},'
            f'"units":"N\\u00b7m"}},"data":"{data}","dtype":"<f8","shape":[2]}}'
        )
        assert object_digest(item) == hashlib.sha256(text.encode()).hexdigest()
        group = hashlib.sha256(b'{"attributes":{},"members":["x"]}').hexdigest()
        assert object_digest(file) == group


def test_manifest_digest_is_that_of_its_text(sealed):
    with h5py.File(sealed) as file:
        text = bytes(file["entry/manifest"][()])
    expected = hashlib.sha256(text).hexdigest()
    assert read(sealed).manifest_sha256 == read_info(sealed).manifest_sha256 == expected
    assert text.startswith(b'{"format":"rigrunner: manifest/1","items":{".":{"kind":"run","sha256"')


def test_embedded_no_load_run_keeps_the_manifest_of_its_own_file(sealed):
    partner = sealed.parent.parent / "no_load"
    assert read(sealed).partners["no_load"].manifest_sha256 == read(partner).manifest_sha256 != ""


def test_unsealed_run_has_no_manifest(tmp_path):
    write_run(tmp_path / "run", TWO)
    assert read(tmp_path / "run").manifest_sha256 == ""


EDITS = {
    "/entry/recordings/_001_10Hz/tester_torque": lambda f: add(
        f, "recordings/_001_10Hz/tester_torque"
    ),
    "/entry/recordings/_001_10Hz/time": lambda f: add(f, "recordings/_001_10Hz/time"),
    "/entry/recordings/_001_10Hz/conditions/tester_temperature": lambda f: add(
        f, "recordings/_001_10Hz/conditions/tester_temperature"
    ),
    "/entry/zeros/tester_torque": lambda f: add(f, "zeros/tester_torque"),
    "/entry/events/monotonic_s": lambda f: add(f, "events/monotonic_s"),
    "/entry/texts/station_text": lambda f: add(f, "texts/station_text"),
    "/entry/analysis/result": lambda f: add(f, "analysis/result"),
    "/entry/analysis/torque/raw": lambda f: add(f, "analysis/torque/raw"),
    "/entry/verification/_001_10Hz/inertia_kg_m2": lambda f: add(
        f, "verification/_001_10Hz/inertia_kg_m2"
    ),
    "/entry/no_load/zeros/tester_torque": lambda f: add(f, "no_load/zeros/tester_torque"),
    "/entry (run)": lambda f: f["entry"].attrs.modify("outcome", "abortee"),
    "/entry/inputs/operator": lambda f: f["entry/inputs/operator"].attrs.modify("text", "Zoé"),
    "/entry/provenance": lambda f: f["entry/provenance"].__delitem__("rigrunner"),
    "/entry/note": lambda f: f["entry"].create_dataset("note", data=1.0),
    "/ (file)": lambda f: f.attrs.modify("default", "other"),
    "/entry/manifest": lambda f: add(f, "manifest"),
}


def add(file, path):
    dataset = file["entry"][path]
    if dataset.shape:
        dataset[0] = dataset[0] + 1
    else:
        dataset[()] = dataset[()] + 1e-9


@pytest.mark.parametrize("where", EDITS)
def test_every_change_of_content_is_located(copy, where):
    texts = [str(difference) for difference in file_differences(edited(copy, EDITS[where]))]
    assert any(text.startswith(where) for text in texts), texts


@pytest.mark.parametrize("where", [path for path in EDITS if "time" not in path])
def test_reading_refuses_a_changed_file(copy, where):
    with pytest.raises(DataError, match=r"not what was|added|cannot be read|damaged"):
        read(edited(copy, EDITS[where]))


def test_removed_and_renamed_objects_are_reported(copy):
    def edit(file):
        group = file["entry/recordings"]
        group.move("_001_10Hz", "_001_11Hz")
        del file["entry/zeros/tester_torque"]

    problems = {
        difference.path: difference.what for difference in file_differences(edited(copy, edit))
    }
    assert problems["recordings/_001_10Hz"].startswith("missing")
    assert problems["recordings/_001_11Hz"].startswith("added")
    assert problems["zeros/tester_torque"].startswith("missing")
    assert set(problems) >= {"recordings", "zeros"}


def test_missing_manifest_is_reported(copy):
    path = edited(copy, lambda file: file["entry"].__delitem__("manifest"))
    (difference,) = file_differences(path)
    assert str(difference).startswith("/entry/manifest (manifest): cannot be read: there is none")
    with pytest.raises(DataError, match="there is none"):
        read(path)


def test_noncanonical_manifest_is_reported(copy):
    def edit(file):
        text = json.dumps(json.loads(bytes(file["entry/manifest"][()])), indent=1)
        del file["entry/manifest"]
        file["entry"].create_dataset("manifest", data=np.frombuffer(text.encode(), np.uint8))

    (difference,) = file_differences(edited(copy, edit))
    assert "not in its canonical form" in str(difference)


def test_file_of_format_1_is_readable(copy):
    def edit(file):
        del file["entry/manifest"], file["entry/no_load/manifest"]
        file.attrs.modify("rigrunner_format", 1)

    run = read(edited(copy, edit))
    assert len(run.recordings) == len(TWO)
    assert run.manifest_sha256 == ""
    assert file_differences(copy) is None


def packed_text(file):
    """A text that is tiny in the file and huge in memory."""
    file["entry/texts"].create_dataset("packed", (1 << 30,), "u1", chunks=(1 << 18,))


def many_names(group):
    """One text under so many names that together they are larger than the file."""
    group["text"] = np.zeros(10_000, "u1")
    for number in range(100):
        group[f"text{number}"] = group["text"]


def samples_in_another_file(file):
    """The digests match as long as nobody changes the other file."""
    other = Path(file.filename).with_name("samples.bin")
    column = file["entry/recordings"].visititems(
        lambda _, item: item if getattr(item, "chunks", None) else None
    )
    values = column[()]
    other.write_bytes(values.tobytes())
    attributes, name = dict(column.attrs), column.name
    del file[name]
    place = [(str(other), 0, other.stat().st_size)]
    new = file.create_dataset(name, (len(values),), "<f8", external=place)
    new.attrs.update(attributes)


def virtual_samples(file):
    layout = h5py.VirtualLayout((3,), "<f8")
    layout[:] = h5py.VirtualSource("elsewhere.h5", "x", (3,))
    file["entry"].create_virtual_dataset("v", layout)


@pytest.mark.parametrize(
    ("edit", "message"),
    [
        (lambda f: f["entry"].__setitem__("round", f["entry"]), "is given twice"),
        (lambda f: f["entry"].__setitem__("out", h5py.ExternalLink("/etc/x", "/")), "is a link"),
        (lambda f: f["entry"].__setitem__("soft", h5py.SoftLink("/entry/zeros")), "is a link"),
        (
            lambda f: f["entry"].create_dataset("huge", (1 << 50,), "f8", chunks=(8,)),
            "larger than the file",
        ),
        (lambda f: f["entry"].__setitem__("type", np.dtype("f8")), "neither group nor dataset"),
        (packed_text, "larger than the file"),
        (lambda f: many_names(f["entry/texts"]), "larger than the file"),
        (samples_in_another_file, "is kept in another file"),
        (virtual_samples, "is kept in another file"),
        (lambda f: f["entry"].create_dataset("o", data="x"), "of a type that no run file has"),
        (lambda f: f["entry"].create_group("/".join("g" * 30)), "nested deeper"),
    ],
)
def test_dangerous_hdf5_structures_are_refused(copy, edit, message):
    edited(copy, edit)
    for reader in (read, read_info, file_differences):
        with pytest.raises(DataError, match=message):
            reader(copy)


def test_flipped_bit_gives_a_result_or_a_data_error(copy):
    """HDF5 libraries raise many errors on damaged files; all must become a DataError."""
    content, rng = copy.read_bytes(), random.Random(4)  # noqa: S311  (seeded, to be repeated)
    for _ in range(examples(25)):
        damaged = bytearray(content)
        damaged[rng.randrange(len(content))] ^= 1 << rng.randrange(8)
        copy.write_bytes(damaged)
        for reader in (file_differences, read, read_info):
            try:
                reader(copy)
            except DataError as error:
                assert str(copy) in str(error)  # noqa: PT017  (an answer is as good)


def test_info_of_an_unsealed_run_is_read_without_samples(tmp_path, monkeypatch):
    write_run(tmp_path / "run", [*TWO, recording("003_30Hz", seed=3)])
    expected = read(tmp_path / "run").info
    monkeypatch.setattr("rigrunner.runfile.loose.read_recording", None)
    assert read_info(tmp_path / "run") == expected
    monkeypatch.undo()
    seal(tmp_path / "run")
    assert read_info(tmp_path / "run").digest == expected.digest


def rewrite(change):
    """Return an edit that rewrites the manifest in its canonical form."""

    def edit(file):
        document = json.loads(bytes(file["entry/manifest"][()]))
        text = json.dumps(change(document), sort_keys=True, separators=(",", ":"))
        del file["entry/manifest"]
        file["entry/manifest"] = np.frombuffer(text.encode("ascii"), np.uint8)

    return edit


@pytest.mark.parametrize(
    ("edit", "message"),
    [
        (rewrite(lambda items: items | {"format": "manifest/0"}), "it is not of the format"),
        (rewrite(lambda items: [items]), "it is not of the format"),
        (rewrite(lambda items: items | {"items": []}), "it is not in its canonical form"),
        (rewrite(lambda items: items | {"remark": "fine"}), "it holds more than its items"),
        (
            lambda file: file["entry/manifest"].attrs.update(remark="fine"),
            "it holds more than its items",
        ),
    ],
)
def test_invalid_manifest_is_refused(copy, edit, message):
    edited(copy, edit)
    with h5py.File(copy) as file, pytest.raises(DataError, match=message):
        stored_items(file["entry"])


def test_comparison_without_samples_skips_only_columns(copy):
    """A column has its own digest, which is checked when it is read."""

    def edit(file):
        add(file, "recordings/_001_10Hz/tester_torque")
        add(file, "recordings/_001_10Hz/conditions/tester_temperature")

    with h5py.File(edited(copy, edit)) as file:
        paths = {difference.path for difference in differences(file["entry"], samples=False)}
        all_paths = {difference.path for difference in differences(file["entry"])}
    assert paths == {"recordings/_001_10Hz/conditions/tester_temperature"}
    assert all_paths == paths | {"recordings/_001_10Hz/tester_torque"}


def test_ctrl_c_while_comparing_a_file_is_raised(sealed, monkeypatch):
    def interrupted(*_arguments):
        raise KeyboardInterrupt

    monkeypatch.setattr("rigrunner.runfile.manifest.object_digest", interrupted)
    with pytest.raises(KeyboardInterrupt):
        file_differences(sealed)


def test_ctrl_c_while_reading_the_manifest_is_raised(sealed, monkeypatch):
    def interrupted(_entry):
        raise KeyboardInterrupt

    monkeypatch.setattr("rigrunner.runfile.manifest.stored_items", interrupted)
    with h5py.File(sealed) as file, pytest.raises(KeyboardInterrupt):
        list(differences(file["entry"]))
