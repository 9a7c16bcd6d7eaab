"""What must hold of the importer old_importer."""

from collections.abc import Callable
from pathlib import Path

import pytest
from rigrunner.api.errors import DataError
from rigrunner.api.importing import NotInFileError

import rigrunner_old_importer as plugin

TEXT = "angle torque\n0.5 1.25\n-0.5 -1.25\n"


@pytest.mark.conformance("importer", "old_importer")
def test_it_keeps_to_what_every_importer_keeps_to(conformance: Callable[[], None]) -> None:
    """One test for each check of the conformance kit; what does not apply is skipped."""
    conformance()


def test_columns_are_found_by_name_and_by_number(tmp_path: Path) -> None:
    """Numbers stand as in the file."""
    file = tmp_path / "run.txt"
    file.write_text(TEXT)
    wanted: dict[str, int | str] = {"tester.torque": "torque", "tester.angle": 1}
    found = plugin.OldImporter().read(file, wanted, "")
    assert found["tester.torque"].values.tolist() == [1.25, -1.25]
    assert found["tester.angle"].values.tolist() == [0.5, -0.5]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("angle torque\n0.5 x\n", "run.txt:2: 'x' is not a number"),
        ("angle torque\n0.5\n", "run.txt:2: has 1 columns, 2 are needed"),
        ("angle torque\n", "has no row"),
    ],
)
def test_a_damaged_file_is_refused_by_its_line(tmp_path: Path, text: str, words: str) -> None:
    """The message says where."""
    file = tmp_path / "run.txt"
    file.write_text(text)
    with pytest.raises(DataError) as caught:
        plugin.OldImporter().read(file, {"tester.torque": "torque"}, "")
    assert words in str(caught.value)


def test_a_column_that_is_not_there_is_named(tmp_path: Path) -> None:
    """With those that are."""
    file = tmp_path / "run.txt"
    file.write_text(TEXT)
    with pytest.raises(NotInFileError, match="columns: angle, torque"):
        plugin.OldImporter().read(file, {"tester.torque": "Torque"}, "")
