"""A run as one file: it round-trips byte by byte, and a mismatch is refused."""

from __future__ import annotations

import json
import os
import shutil
import stat
from zipfile import ZIP_DEFLATED, ZIP_STORED, ZipFile, ZipInfo

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from helpers_cli import call
from helpers_thorough import examples
from rigrunner.api.errors import DataError, RigrunnerError, UsageError
from rigrunner.documents.packing.contents import LISTING, is_safe, parse_contents
from rigrunner.documents.packing.pack import _packed_files, pack
from rigrunner.documents.packing.unpack import unpack
from unit.rigrunner_fleet.archive.helpers_archive import store_run
from unit.runfile.helpers_runfile import recording, write_run


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = store_run(tmp_path_factory.mktemp("runs"), "20260301T120000Z_PROC_SN-1")
    (folder / "result.json").write_text("{}\n")
    (folder / "certificates").mkdir()
    (folder / "certificates/C-1.json").write_text("{}\n")
    return folder


@pytest.fixture(scope="module")
def packed(run, tmp_path_factory):
    target = tmp_path_factory.mktemp("packed") / "run.zip"
    pack(run, target)
    return target


def files(folder):
    paths = (path for path in folder.rglob("*") if path.is_file() and path.name != "run.lock")
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in paths}


def test_packed_run_round_trips_byte_by_byte(run, packed, tmp_path):
    unpacked = unpack(packed, tmp_path / "there")
    assert unpacked == tmp_path / "there" / run.name
    assert files(unpacked) == files(run)
    assert stat.S_IMODE((unpacked / "run.h5").stat().st_mode) == 0o444
    assert [path.name for path in (tmp_path / "there").iterdir()] == [run.name]


def test_packing_is_reproducible(run, packed, tmp_path):
    os.utime(run / "result.json", ns=(10**18, 10**18))
    pack(run, tmp_path / "again.zip")
    assert (tmp_path / "again.zip").read_bytes() == packed.read_bytes()


def test_list_can_be_checked_with_the_standard_library(run, packed):
    import hashlib  # noqa: PLC0415  (as a third party would)

    with ZipFile(packed) as file:
        listing = json.loads(file.read("rigrunner-packed-run.json"))
        for entry in listing["files"]:
            content = file.read(f"{listing['folder']}/{entry['name']}")
            assert len(content) == entry["bytes"]
            assert hashlib.sha256(content).hexdigest() == entry["sha256"]
    assert [entry["name"] for entry in listing["files"]] == sorted(files(run))


def test_existing_run_and_file_are_not_overwritten(run, packed):
    with pytest.raises(UsageError, match="exists"):
        unpack(packed, run.parent)
    with pytest.raises(UsageError, match="exists"):
        pack(run, packed)


def test_file_changed_while_packing_is_refused(run, tmp_path, monkeypatch):
    folder = shutil.copytree(run, tmp_path / "runs" / run.name)

    def change_after_listing(*arguments):
        listed_files = list(_packed_files(*arguments))
        (folder / "result.json").write_text("[]\n")  # as long as before
        return listed_files

    monkeypatch.setattr("rigrunner.documents.packing.pack._packed_files", change_after_listing)
    with pytest.raises(DataError, match=r"result\.json was changed meanwhile"):
        pack(folder, tmp_path / "packed.zip")
    assert [path.name for path in tmp_path.iterdir()] == ["runs"]


def test_hidden_files_are_not_packed(run, tmp_path):
    """File managers leave them, and they may contain commands: `unpack` refuses them."""
    copy = shutil.copytree(run, tmp_path / run.name)
    (copy / ".DS_Store").touch()
    (copy / ".git").mkdir()
    (copy / ".git" / "config").touch()
    names = [file.name for file in pack(copy, tmp_path / "x.rigrun").files]
    assert names == sorted(files(run))


def test_unsealed_or_damaged_run_is_not_packed(run, tmp_path):
    (tmp_path / "loose").mkdir()
    write_run(tmp_path / "loose", [recording()])
    with pytest.raises(DataError, match="is not sealed"):
        pack(tmp_path / "loose", tmp_path / "loose.zip")
    linked = tmp_path / "linked"
    linked.mkdir()
    (linked / "run.h5").write_bytes((run / "run.h5").read_bytes())
    (linked / "passwd").symlink_to("/etc/passwd")
    with pytest.raises(DataError, match="not a regular file"):
        pack(linked, tmp_path / "linked.zip")
    damaged = tmp_path / "damaged"
    damaged.mkdir()
    (damaged / "run.h5").write_bytes((run / "run.h5").read_bytes()[:-400])
    with pytest.raises(DataError):
        pack(damaged, tmp_path / "damaged.zip")
    assert list(tmp_path.glob("*.zip*")) == []


def repacked(packed, target, change, *, kind=ZIP_STORED):
    """Write the members of a packed run to another file, after `change(contents by name)`."""
    with ZipFile(packed) as file:
        members = {name: file.read(name) for name in file.namelist()}
    change(members)
    with ZipFile(target, "w") as file:
        for name, content in members.items():
            file.writestr(ZipInfo(name), content, kind)
    return target


def change_listing(members, **changes):
    content = json.loads(members[LISTING]) | changes
    members[LISTING] = json.dumps(content).encode()
    return content


def rename_file(name):
    def change(members):
        contents = json.loads(members[LISTING])
        old = f"{contents['folder']}/result.json"
        for entry in contents["files"]:
            entry["name"] = name if entry["name"] == "result.json" else entry["name"]
        members[f"{contents['folder']}/{name}"] = members.pop(old)
        members[LISTING] = json.dumps(contents).encode()

    return change


def flip(members):
    name = next(name for name in members if name.endswith("run.h5"))
    content = bytearray(members[name])
    content[len(content) // 2] ^= 1
    members[name] = bytes(content)


def flip_with_digest(members):
    """Change the run file and its entry in the list: only its own manifest can detect it."""
    import hashlib  # noqa: PLC0415  (here alone)

    name = next(name for name in members if name.endswith("run.h5"))
    members[name] = members[name][:-300]
    contents = json.loads(members[LISTING])
    for entry in contents["files"]:
        if entry["name"] == "run.h5":
            sha256 = hashlib.sha256(members[name]).hexdigest()
            entry.update(bytes=len(members[name]), sha256=sha256)
    members[LISTING] = json.dumps(contents).encode()


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (rename_file("../../evil"), "leads out of the folder"),
        (rename_file("/etc/evil"), "leads out of the folder"),
        (rename_file("C:evil"), "leads out of the folder"),
        (rename_file("a\\b"), "leads out of the folder"),
        (lambda members: change_listing(members, folder=".."), "leads out of the folder"),
        (lambda members: change_listing(members, folder="a/b"), "leads out of the folder"),
        (lambda members: change_listing(members, folder=".git"), "leads out of the folder"),
        (rename_file(".vscode/tasks.json"), "leads out of the folder"),
        (
            lambda members: change_listing(members, folder="other"),
            "does not contain the files in its list",
        ),
        (lambda members: change_listing(members, run="other"), "of another run"),
        (lambda members: change_listing(members, digest_sha256="0" * 64), "of another run"),
        (lambda members: change_listing(members, format="rigrunner: packed run/2"), "format"),
        (lambda members: members.update(extra=b""), "does not contain the files in its list"),
        (lambda members: members.pop(LISTING), "not a packed run"),
        (flip, "does not match its SHA-256"),
        (flip_with_digest, "run.h5"),
    ],
)
def test_mismatching_package_is_refused_and_leaves_no_file(packed, tmp_path, change, words):
    changed = repacked(packed, tmp_path / "odd.zip", change)
    with pytest.raises(DataError, match=words):
        unpack(changed, tmp_path / "runs" / "deep")
    remaining = [path for path in (tmp_path / "runs").rglob("*") if path.is_file()]
    assert remaining == []


def test_files_stay_writable_until_they_are_verified(packed, tmp_path, monkeypatch):
    """Windows does not remove read-only files; this checks their mode when verification fails."""
    modes = []

    def record_mode(_packed, _contents, file):
        modes.append(file.stat().st_mode & stat.S_IWUSR)
        raise DataError("it is not the same")

    monkeypatch.setattr("rigrunner.documents.packing.unpack._require_same", record_mode)
    with pytest.raises(DataError):
        unpack(packed, tmp_path / "runs")
    assert modes == [stat.S_IWUSR]


def test_compressed_package_is_refused_before_extraction(packed, tmp_path):
    bomb = repacked(packed, tmp_path / "bomb.zip", lambda _: None, kind=ZIP_DEFLATED)
    with pytest.raises(DataError, match="is compressed"):
        unpack(bomb, tmp_path / "runs")
    assert not (tmp_path / "runs").exists()


@settings(max_examples=examples(60), suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(change=st.tuples(st.floats(0, 1, exclude_max=True), st.integers(0, 7), st.booleans()))
def test_flipped_bit_or_cut_gives_the_same_run_or_an_error(run, packed, tmp_path_factory, change):
    (place, bit, cut), content = change, bytearray(packed.read_bytes())
    at = int(place * len(content))
    content[at] ^= 1 << bit
    folder = tmp_path_factory.mktemp("odd")
    (folder / "odd.zip").write_bytes(content[:at] if cut else content)
    try:
        unpacked = unpack(folder / "odd.zip", folder / "runs")
    except RigrunnerError:
        assert not list((folder / "runs").glob("*"))
    else:
        assert files(unpacked) == files(run)


@pytest.mark.parametrize("name", ["run.h5", "a/b.json", "Prüfung 1.pdf", "a.b/c"])
def test_safe_names_are_accepted(name):
    assert is_safe(name)


@pytest.mark.parametrize(
    "name",
    [
        *("", ".", "..", "a/../b", "/a", "a//b", "a/", "a\\b", "c:", "a. ", "\0"),
        *("nul", "COM1.txt", "com¹", "CONIN$"),
        *(".git", ".git/config", "a/.vscode/x"),
        *("a\x9bb", "a\N{RIGHT-TO-LEFT OVERRIDE}b"),
    ],
)
def test_unsafe_names_are_refused(name):
    assert not is_safe(name)


@given(st.binary(max_size=200))
def test_invalid_list_is_a_data_error(text):
    with pytest.raises(DataError):
        parse_contents(text)


def test_pack_and_unpack_commands(run, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = call("pack", run)
    assert result.code == 0, result.err
    assert result.out.startswith(f"{run.name}.zip: 3 files, ")
    result = call("unpack", f"{run.name}.zip")
    assert (result.code, result.out) == (0, f"runs/{run.name}\n")
    for words, code, message in (
        (["unpack", f"{run.name}.zip"], 2, "exists"),
        (["unpack", "none.zip"], 2, "there is no none.zip"),
        (["unpack", run / "result.json"], 5, "is not a packed run"),
        (["pack", "none"], 2, "there is no run 'none'"),
    ):
        result = call(*words)
        assert result.code == code
        assert message in result.err
        assert "Traceback" not in result.err
