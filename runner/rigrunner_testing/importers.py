"""Checks on importers: for any file, the wanted columns or a DataError."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

import numpy as np

from rigrunner.api.errors import DataError
from rigrunner.api.hooks import ImporterRecord
from rigrunner.api.importing import Column, NotInFileError
from rigrunner_testing.check import AnyCheck, Nonconformity, applies, check, demand
from rigrunner_testing.device.watching import census, leaks_since

if TYPE_CHECKING:
    from collections.abc import Iterator

    from rigrunner.api.hooks import ImporterExample
    from rigrunner.api.importing import Importer
    from rigrunner_testing.subjects import Subject

Columns = dict[str, "int | str"]
WANTED: Columns = {"tester.torque": "torque", "tester.angle": "angle"}
CUTS = 25
"""The number of places at which an example is cut."""
FOREIGN = {
    "empty": b"",
    "zeros": bytes(4096),
    "all bytes": bytes(range(256)) * 16,
    "a picture": b"\x89PNG\r\n\x1a\n" + bytes(100),
    "a sentence": b"Measured on Monday, by hand.\n",
    "half a number": b"torque\tangle\n1.0\t2.0\n3.",
    "no number": b"torque;angle\nhigh;low\n",
    "not finite": b"torque,angle\nnan,inf\n",
    "UTF-16": "torque\tangle\n1\t2\n".encode("utf-16"),
    "a long line": b"7" * 100_000,
    "JSON": b'{"torque": [1, 2], "angle": null}',
    "HDF5, cut": b"\x89HDF\r\n\x1a\n" + bytes(32),
    "a zip": b"PK\x03\x04" + bytes(60),
    "TDMS, cut": b"TDSm" + bytes(24),
    "MATLAB 5, cut": b"MATLAB 5.0 MAT-file" + b" " * 105 + b"\x00\x01IM" + bytes(8),
}


@check(fix="catch OSError and raise DataError with the file's name")
def missing_file_refused(subject: Subject) -> None:
    """A missing file, or a folder, is refused by its name."""
    with TemporaryDirectory() as folder:
        for path in (Path(folder) / "missing.dat", Path(folder)):
            message = _refusal(_importer(subject), path)
            demand(message, f"it reads {path.name}, which is not a file")
            demand(path.name in message, f"it refuses {path.name} without naming it: {message}")


@check(
    fix="look at the first bytes, and map what the library raises to DataError",
    needs=("missing_file_refused",),
)
def foreign_files_refused(subject: Subject) -> None:
    """Any file gives finite numbers of each wanted column, or a DataError naming it."""
    importer = _importer(subject)
    with TemporaryDirectory() as folder:
        for what, content in FOREIGN.items():
            path = Path(folder) / "foreign.dat"
            path.write_bytes(content)
            message = _read_or_refusal(importer, path, what)
            demand(
                not message or path.name in message, f"{what}: it does not name the file: {message}"
            )


@check(fix="close the file in every case: `with open(...)`", needs=("foreign_files_refused",))
def closes_its_files(subject: Subject) -> None:
    """It leaves no file open, also of refused ones."""
    importer = _importer(subject)
    with TemporaryDirectory() as folder:
        paths = []
        for number, content in enumerate(FOREIGN.values()):
            paths.append(Path(folder) / f"{number}.dat")
            paths[-1].write_bytes(content)
        for path in paths:  # so that lazy imports do not count
            _refusal(importer, path)
        before = census()
        for path in paths:
            _refusal(importer, path)
        leaks = leaks_since(before)
        demand(not leaks, f"it left open: {leaks}")


@check(
    fix="correct the importer, or the example that the record states",
    needs=("missing_file_refused",),
)
def examples_are_read(subject: Subject) -> None:
    """The example files in the record give the stated numbers."""
    for example, path in _examples(subject):
        columns = _importer(subject).read(path, example.columns, example.group)
        _check_columns(columns, dict(example.columns), example.source)
        for name, stated in example.values.items():
            values = columns[name].values
            is_same = values.shape == (len(stated),) and np.allclose(values, stated, rtol=1e-12)
            demand(is_same, f"{example.source}: {name} is {values}, stated is {stated}")


@check(
    fix="raise NotInFileError with `wanted`, and the columns that are there as its hint",
    needs=("examples_are_read",),
)
def missing_columns_are_named(subject: Subject) -> None:
    """A column that an example lacks is refused by its name."""
    for example, path in _examples(subject):
        name = next(iter(example.columns))
        try:
            _importer(subject).read(path, {name: "no such column"}, example.group)
        except NotInFileError as error:
            is_named = "no such column" in str(error)
            demand(is_named, f"it refuses a column without naming it: {error}")
        except Exception as error:
            raise Nonconformity(
                f"a column that is not there gives {type(error).__name__}, not NotInFileError:"
                f" {error}"
            ) from error
        else:
            raise Nonconformity("it gives a column that is not there")


@check(
    fix="check lengths before you read, and map what the library raises to DataError",
    needs=("examples_are_read",),
)
def cut_files_refused(subject: Subject) -> None:
    """A truncated example gives a DataError, or fewer complete rows."""
    for example, path in _examples(subject):
        content, importer = path.read_bytes(), _importer(subject)
        for length in np.linspace(0, len(content) - 1, CUTS).astype(int):
            path.write_bytes(content[:length])
            what = f"{example.source}, cut to {length} of {len(content)} bytes"
            _read_or_refusal(importer, path, what, example)


def _examples(subject: Subject) -> Iterator[tuple[ImporterExample, Path]]:
    examples = subject.record_as(ImporterRecord).examples
    applies(examples, "its record states no examples")
    with TemporaryDirectory() as folder:
        for example in examples:
            path = Path(folder) / f"example{example.suffix}"
            path.write_bytes(example.content)
            yield example, path


def _importer(subject: Subject) -> Importer:
    importer: Importer = subject.make()
    return importer


def _refusal(importer: Importer, path: Path) -> str:
    """Return the message with which the file is refused; '' if it is read."""
    try:
        importer.read(path, WANTED, "")
    except DataError as error:
        return str(error)
    except Exception as error:
        raise Nonconformity(
            f"{path.name} gives {type(error).__name__}, which is not a DataError: {error}"
        ) from error
    return ""


def _read_or_refusal(
    importer: Importer, path: Path, what: str, example: ImporterExample | None = None
) -> str:
    """Return the message with which the file is refused; '' if the data are complete."""
    columns, group = (WANTED, "") if example is None else (dict(example.columns), example.group)
    try:
        data = importer.read(path, columns, group)
    except DataError as error:
        return str(error)
    except Exception as error:
        raise Nonconformity(
            f"{what}: {type(error).__name__}, which is not a DataError: {error}"
        ) from error
    _check_columns(data, columns, what)
    return ""


def _check_columns(data: Mapping[str, Column], expected: Columns, what: str) -> None:
    demand(
        isinstance(data, Mapping) and all(isinstance(column, Column) for column in data.values()),
        f"{what}: `read` gave {data!r:.80}, expected a Column for each name that is wanted",
        fix="return `{name: Column(values), ...}`: is there a `return`?",
    )
    demand(set(data) == set(expected), f"{what}: wanted {[*expected]}, it gives {[*data]}")
    for name, column in data.items():
        finite = column.values.ndim == 1 and np.isfinite(column.values).all()
        demand(finite, f"{what}: {name} holds numbers that are not finite")
    lengths = {len(column.values) for column in data.values()}
    demand(len(lengths) == 1, f"{what}: the columns have {sorted(lengths)} numbers")


CHECKS: tuple[AnyCheck, ...] = (
    missing_file_refused,
    foreign_files_refused,
    closes_its_files,
    examples_are_read,
    missing_columns_are_named,
    cut_files_refused,
)
