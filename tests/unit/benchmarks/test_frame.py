import json
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

from benchmarks import command, page, peer
from benchmarks.frame import (
    Figure,
    Scale,
    Spread,
    allocated_peak,
    at_least,
    at_most,
    calls,
    pair_of,
)
from benchmarks.frame import peer as peer_figure
from benchmarks.peer import Peers
from benchmarks.tables import number, table


def test_spread_is_median_and_quartiles():
    assert Spread.of([5.0, 1.0, 3.0, 2.0, 4.0]) == Spread(3.0, 2.0, 4.0)
    assert Spread.of([7.0]) == Spread(7.0, 7.0, 7.0)


def test_rate_is_high_for_short_times():
    assert Spread(2.0, 1.0, 4.0).rate(8) == Spread(4.0, 2.0, 8.0)


def test_ratios_are_computed_per_turn():
    pair = pair_of([(2.0, 1.0), (40.0, 10.0), (3.0, 1.0)])  # another load disturbed the second turn
    assert pair.ratio.median == 3.0
    assert pair.speed.median == 1 / 3
    assert (pair.ours.median, pair.floor.median) == (3.0, 1.0)


def figure(target, value=3.0, ratio=0.2):
    ratios = None if ratio is None else Spread.of([ratio])
    return Figure("x", Spread.of([value]), "s", ratio=ratios, target=target)


@pytest.mark.parametrize(
    ("target", "met"),
    [
        (at_least(0.25), False),
        (at_least(0.2), True),
        (at_most(0.2), True),
        (at_most(0.1), False),
        (at_most(2.5, "s"), False),
        (at_most(3.0, "s"), True),
        (None, None),
    ],
)
def test_target_without_unit_applies_to_the_ratio(target, met):
    assert figure(target).met() is met


def test_unmeasured_target_is_neither_met_nor_missed():
    assert Figure("x", None, "s", target=at_most(1.0, "s")).met() is None
    assert figure(at_most(1.0), ratio=None).met() is None


def test_table_has_a_line_per_figure():
    header, rule, missed, skipped = table(
        [figure(at_least(0.25)), Figure("theirs", None, "s", "peer", note="skipped: why")]
    ).splitlines()
    assert len(header) == len(rule) == len(missed) == len(skipped)
    cells = [cell.strip() for cell in missed.strip("|").split("|")]
    assert cells == ["ours", "x", "3.00 s", "0.2", "≥ 0.25", "**no**", ""]
    assert [cell.strip() for cell in skipped.strip("|").split("|")][-1] == "skipped: why"


@pytest.mark.parametrize(
    ("value", "text"),
    [(0, "0"), (0.0123456, "0.0123"), (1.234, "1.23"), (45.67, "45.7"), (678.9, "679"),
     (1234567.0, "1,234,567"), (2.5e-5, "2.5e-05"), (-3.0, "-3.00")],
)  # fmt: skip
def test_numbers_have_three_significant_digits(value, text):
    assert number(value) == text


def test_calls_and_bytes_are_counted():
    assert calls(lambda: [abs(-1) for _ in range(10)]) >= 11
    assert calls(lambda: [abs(-1) for _ in range(100)]) - calls(lambda: None) >= 100
    assert 1_000_000 <= allocated_peak(lambda: bytearray(1_000_000)) < 1_100_000


@pytest.fixture
def scripts(tmp_path, monkeypatch):
    monkeypatch.setattr(peer, "SCRIPTS", tmp_path)
    return tmp_path


def test_numbers_of_a_peer_are_its_last_output(scripts):
    (scripts / "one.py").write_text(
        "import sys, json\nprint('hi')\nprint([1, 2, int(sys.argv[1])])"
    )
    scale = Scale(peers=Peers(Path(sys.executable)))
    theirs = peer_figure(scale, "theirs", "one", 3, unit="us", floor=Spread.of([4.0]))
    assert (theirs.value.median, theirs.ratio.median, theirs.role) == (2.0, 0.5, "peer")


@pytest.mark.parametrize(
    ("code", "note"),
    [
        ("import nowhere_at_all", "skipped: not installed (No module named 'nowhere_at_all')"),
        ("raise ValueError('odd')", "failed: ValueError: odd"),
        ("raise SystemExit(3)", "failed: exit 3"),
    ],
)
def test_failing_peer_states_the_reason(scripts, code, note):
    (scripts / "one.py").write_text(code)
    assert peer_figure(Scale(peers=Peers(Path(sys.executable))), "x", "one", unit="s").note == note


def test_peers_without_an_environment_are_skipped():
    assert peer_figure(Scale(), "x", "one", unit="s").note == "skipped: not installed"
    assert Peers().versions(["numpy"]) == "not installed"


def test_peers_report_versions():
    assert Peers(Path(sys.executable)).versions(["numpy", "nowhere"]).startswith("numpy ")


@pytest.fixture
def two_benchmarks(monkeypatch):
    """Replace the benchmarks by one that measures and one that fails."""
    good = SimpleNamespace(__doc__="About it.", measure=lambda _: [figure(at_least(9.0))])
    bad = SimpleNamespace(__doc__="", measure=lambda _: json.loads("{"))
    monkeypatch.setattr(command, "names", lambda: ["bad", "good"])
    monkeypatch.setattr(command, "benchmark", {"bad": bad, "good": good}.get)


@pytest.mark.usefixtures("two_benchmarks")
def test_failing_benchmark_does_not_stop_others(capsys):
    assert command.main([]) == 1
    out = capsys.readouterr().out
    assert "## bad\n\nFailed: JSONDecodeError" in out
    assert "## good\n\nAbout it.\n\n|" in out
    assert out.startswith("Measured ")


def write_page(tmp_path, tables):
    path = tmp_path / "page.md"
    path.write_text(f"before\n{page.BEGIN}\n{tables}{page.END}\nafter\n", encoding="utf-8")
    return path


@pytest.mark.usefixtures("two_benchmarks")
def test_page_changes_only_between_its_marks(tmp_path):
    path = write_page(tmp_path, "old\n")
    assert command.main(["good", "--markdown", str(path), "--short"]) == 0
    text = path.read_text(encoding="utf-8")
    assert text.startswith(f"before\n{page.BEGIN}\nMeasured ")
    assert text.endswith(f").\n{page.END}\nafter\n")
    assert "The short form" in text
    assert "old" not in text
    assert f"## bad\n\n{page.LATER}\n" in text


@pytest.mark.usefixtures("two_benchmarks")
def test_page_keeps_other_benchmarks_and_drops_removed_ones(tmp_path):
    path = write_page(tmp_path, "head\n\n## bad\n\nof old\n\n## gone\n\nx\n\n## good\n\nold\n")
    command.main(["good", "--markdown", str(path)])
    text = path.read_text(encoding="utf-8")
    assert "\n\n## bad\n\nof old\n\n## good\n\nAbout it.\n\n|" in text
    assert "gone" not in text
    command.main(["good", "--markdown", str(path)])
    again = path.read_text(encoding="utf-8")
    assert again.count("## good") == again.count("## bad") == again.count("Measured") == 1


@pytest.mark.usefixtures("two_benchmarks")
@pytest.mark.parametrize(("options", "judged"), [([], True), (["--short"], False)])
def test_short_form_does_not_judge_targets(options, judged, capsys):
    command.main(["good", *options])
    assert ("**no**" in capsys.readouterr().out) is judged


@pytest.mark.usefixtures("two_benchmarks")
def test_new_page_is_written_whole(tmp_path):
    command.main(["good", "--markdown", str(tmp_path / "new.md")])
    assert (tmp_path / "new.md").read_text(encoding="utf-8").startswith("Measured ")


@pytest.mark.usefixtures("two_benchmarks")
@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["god"], "no benchmark god; there are bad, good"),
        (["--peers", "/nowhere/python"], "no program /nowhere/python"),
    ],
)
def test_invalid_arguments_are_refused(options, message, capsys):
    with pytest.raises(SystemExit) as caught:
        command.main(options)
    assert caught.value.code == 2
    assert message in capsys.readouterr().err
