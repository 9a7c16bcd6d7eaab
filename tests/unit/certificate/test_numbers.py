"""No certificate number is issued twice, even concurrently, and each gap is explained."""

from __future__ import annotations

import json
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from helpers_thorough import examples
from rigrunner.api.errors import DataError
from rigrunner.certificate.numbers import Numbers
from rigrunner.certificate.withdrawal import Withdrawal

RECORD = {"by": "A. Nother", "run": "r"}
RESERVE = """
import sys
from pathlib import Path
from rigrunner.certificate.numbers import Numbers
for _ in range(20):
    print(Numbers(Path(sys.argv[1]), "RR").reserve(2026, {}))
"""


def test_numbers_count_from_one_per_year_and_prefix(tmp_path):
    numbers = Numbers(tmp_path, "RR")
    assert [numbers.reserve(2026, RECORD) for _ in range(3)] == [
        *("RR-2026-0001", "RR-2026-0002", "RR-2026-0003"),
    ]
    assert numbers.reserve(2027, RECORD) == "RR-2027-0001"
    assert Numbers(tmp_path, "RRX").reserve(2026, RECORD) == "RRX-2026-0001"
    assert Numbers(tmp_path, "R").reserve(2026, RECORD) == "R-2026-0001"


def test_details_are_stored_with_the_number(tmp_path):
    number = Numbers(tmp_path, "RR").reserve(2026, RECORD)
    text = (tmp_path / "numbers" / f"{number}.json").read_text(encoding="utf-8")
    assert json.loads(text) == {"number": number, **RECORD}


def test_lower_free_number_is_not_used(tmp_path):
    numbers = Numbers(tmp_path, "RR")
    numbers.reserve(2026, RECORD)
    (tmp_path / "numbers" / "RR-2026-0041.json").write_text("{}")
    assert numbers.reserve(2026, RECORD) == "RR-2026-0042"


def test_next_number_is_not_reserved(tmp_path):
    numbers = Numbers(tmp_path, "RR")
    assert [numbers.next(2026), numbers.next(2026)] == ["RR-2026-0001"] * 2
    assert not numbers.kept
    assert numbers.reserve(2026, {}) == "RR-2026-0001"
    assert numbers.next(2026) == "RR-2026-0002"


def test_ten_thousand_is_sorted_after_9999(tmp_path):
    numbers = Numbers(tmp_path, "RR")
    numbers.reserve(2026, RECORD)
    (tmp_path / "numbers" / "RR-2026-9998.json").write_text("{}")
    reserved = [numbers.reserve(year, RECORD) for year in (2026, 2026, 2027)]
    assert reserved == ["RR-2026-9999", "RR-2026-10000", "RR-2027-0001"]
    assert numbers.interrupted() == ["RR-2026-0001", "RR-2026-9998", *reserved]
    for number in reversed(reserved):
        numbers.issued(number, {})
    assert numbers.in_force_for("r") == "RR-2026-9999"


def test_concurrent_processes_get_different_numbers(tmp_path):
    command = [sys.executable, "-c", RESERVE, str(tmp_path)]
    with ThreadPoolExecutor(4) as pool:
        outputs = list(pool.map(lambda _: subprocess.check_output(command, text=True), range(4)))
    numbers = " ".join(outputs).split()
    assert sorted(numbers) == [f"RR-2026-{number:04d}" for number in range(1, 81)]


def test_reserved_but_unused_number_is_reported(tmp_path):
    numbers = Numbers(tmp_path, "RR")
    first, second, third = (numbers.reserve(2026, RECORD) for _ in range(3))
    numbers.issued(first, {})
    numbers.void(third, "disk full")
    assert numbers.interrupted() == [second]


def test_number_in_force_is_the_last_issued_and_not_replaced(tmp_path):
    numbers = Numbers(tmp_path, "RR")
    first, second, third, void = (
        numbers.reserve(2026, details)
        for details in (RECORD, RECORD | {"amends": "RR-2026-0001"}, RECORD | {"run": "q"}, RECORD)
    )
    numbers.void(void, "disk full")
    assert numbers.in_force_for("r") == ""
    numbers.issued(first, {})
    assert numbers.in_force_for("r") == first
    numbers.issued(second, {})
    numbers.issued(third, {})
    assert (numbers.in_force_for("r"), numbers.in_force_for("q"), numbers.in_force_for("s")) == (
        *(second, third, ""),
    )


def test_withdrawn_number_is_not_in_force_and_never_comes_back(tmp_path):
    numbers = Numbers(tmp_path, "RR")
    first, second, copy = (
        numbers.reserve(2026, details)
        for details in (RECORD, RECORD | {"amends": "RR-2026-0001"}, RECORD)
    )
    numbers.issued(first, {})
    numbers.issued(second, {})
    assert numbers.withdrawal_of(second) is None
    withdrawal = Withdrawal(number=second, sha256="", by="B", utc="2026-11-30", reason="wrong")
    numbers.withdraw(withdrawal)
    assert numbers.withdrawal_of(second) == withdrawal
    assert (numbers.in_force_for("r"), numbers.withdrawn_for("r")) == ("", second)
    with pytest.raises(FileExistsError):
        numbers.withdraw(withdrawal)
    assert numbers.replaced_by(first) == second
    assert numbers.interrupted() == [copy]
    numbers.issued(copy, {})
    assert (numbers.in_force_for("r"), numbers.withdrawn_for("r")) == (copy, second)
    newer = numbers.reserve(2026, RECORD | {"amends": second})
    numbers.issued(newer, {})
    assert numbers.withdrawn_for("r") == ""


def test_folder_that_cannot_be_written_is_named(tmp_path):
    (tmp_path / "numbers").write_text("a file")
    with pytest.raises(DataError, match=r"cannot keep the number in .*numbers: "):
        Numbers(tmp_path, "RR").reserve(2026, RECORD)


@settings(deadline=None, max_examples=examples(25))  # each number is synced to the disk
@given(st.lists(st.sampled_from(["RR", "R", "RRX"]), max_size=12))
def test_numbers_are_unique_across_mixed_prefixes(tmp_path_factory, prefixes):
    folder = tmp_path_factory.mktemp("lab")
    numbers = [Numbers(folder, prefix).reserve(2026, RECORD) for prefix in prefixes]
    assert len(set(numbers)) == len(prefixes)
    for prefix in set(prefixes):
        count = prefixes.count(prefix)
        assert [number for number in numbers if number.startswith(f"{prefix}-")] == [
            f"{prefix}-2026-{number:04d}" for number in range(1, count + 1)
        ]


@pytest.mark.parametrize(
    "text", ["[" * 100_000, '{"sha256": {"a": [], "b": {}, "c": 1}}', '{"sha256": 7}', "\ud800"]
)
def test_invalid_record_is_ignored(text, tmp_path):
    (tmp_path / "numbers").mkdir()
    for name in ("RR-2026-0001.json", "RR-2026-0001.issued.json"):
        (tmp_path / "numbers" / name).write_bytes(text.encode("utf-8", "surrogatepass"))
    numbers = Numbers(tmp_path, "RR")
    assert numbers.digests_of("RR-2026-0001") == set()
    assert numbers.replaced_by("RR-2026-0000") == ""
