"""Editors complete, check and explain procedures and stations, by yaml-language-server.

RIGRUNNER_REQUIRE_YAML_SERVER=1 makes a missing server a failure instead of a skip.
"""

from __future__ import annotations

import re
import shutil
from itertools import count

import pytest

from e2e.helpers_lsp import YamlServer
from helpers_docs import ROOT, code_blocks, pages
from helpers_lacking import lacking
from rigrunner.station import parse_station

PROCEDURES = ROOT / "procedures"
SERVER = "yaml-language-server"
PROCEDURE = """\
# yaml-language-server: $schema=./procedure.schema.json
rigrunner: procedure/2
id: TEST-1
revision: "A"
title: A test
measurand: {symbol: Td, name: torque, unit: N·m}
inputs:
  specimen: {ask: Serial number, unattended: S-1}
uses: {tester: swing_tester}
parameters: {load: 1000 N, frequencies: [1 Hz, 5 Hz]}
setup:
  - confirm: {text: Guards closed, unattended: yes}
  - zero: {channel: tester.torque, within: 0.05 N·m, retries: 2}
main:
  - set: {tester.load: $load}
  - sweep:
      set: tester.frequency
      over: $frequencies
      steps:
        - settle: {cycles: 5}
        - measure: {channels: [tester.load], limits: {tester.load: {min: 900 N, marginal: 10 N}}}
        - record: {channels: [tester.angle, tester.torque], cycles: 30}
teardown:
  - ramp: {drive: tester.load, to: 0 N, rate: 100 N/s}
analysis:
  - swing_torque:
      no_load: {from: latest, procedure: TEST-0, max_age: 30 d, same: [station, mandrel]}
      despike: {hampel: {window: 11}}
      outliers: {grubbs: {alpha: 0.05}}
      fits:
        - polynomial: {degree: 2}
      compensations:
        - paper_peak: {coefficients: refit}
        - template_inverse
        - energy
      primary: template_inverse
acceptance:
  limits:
    - of: torque
      mean: yes
      max: 0.95 N·m
      source: nobody
      measurand: {nature: load_induced, condition: at_reversal}
  rule: guard_band_u
"""
STATION = """\
# yaml-language-server: $schema=./station.schema.json
rigrunner: station/1
id: bench-1
title: A bench
rig:
  mandrel: M-01
  eccentric: 2 mm
  centre_distance: 45 mm
  inertia: 0.00233 kg·m²
  support_friction: 0.76 N·m
  support_damping: 0.31 N·m·s/rad
devices:
  tester:
    type: swing_tester
    plugin: swing_tester_sim
    settings: {seed: 1}
instruments:
  - channel: tester.torque
    serial: SIM-TQ-01
    full_scale: 10 N·m
    accuracy: {gain: 0.3 %, offset: 0.02 N·m, drift: 0.02 N·m, nonlinearity: 0.05 %}
"""
REGISTER = f"""\
{STATION}    points: [{{applied: 5 N·m, indicated: 5.01 N·m, U: 0.01 N·m, k: 2}}]
    range: {{min: -10 N·m, max: 10 N·m}}
  - channel: tester.angle
    measures: angle
    serial: "1"
    calibration: simulated
  - channel: tester.load
    measures: force
    id: LC-3
    serial: "2"
    certificate: K-1
    due: 2027-01-31
    accuracy: 0.1 % FS
    conditions: {{temperature: {{min: 18 °C, max: 28 °C}}}}
"""
SHIPPED = sorted(PROCEDURES.rglob("*.yaml"))


@pytest.fixture(scope="module")
def server(tmp_path_factory):
    program = shutil.which(SERVER)
    if program is None:
        lacking("YAML_SERVER", f"{SERVER} is not installed: npm install --global {SERVER}")
    folder = tmp_path_factory.mktemp("lab")
    (folder / "stations").mkdir()
    for schema in PROCEDURES.glob("*.schema.json"):
        shutil.copy(schema, folder)
    with YamlServer(program, folder) as running:
        yield running


class Editor:
    """A text in the editor; '‸' in it is the position of the cursor."""

    numbers = count()

    def __init__(self, server, text, folder=""):
        before, at, after = text.partition("‸")
        self.path = server.folder / folder / f"{next(self.numbers)}.yaml"
        self._cursor = (before.count("\n"), len(before.rpartition("\n")[2])) if at else None
        self._server = server
        self.diagnostics = server.open(self.path, before + after)

    def completions(self):
        return {item["label"]: item for item in self._server.completions(self.path, *self._cursor)}

    def hover(self):
        return self._server.hover(self.path, *self._cursor)


def edited(text, old, new):
    assert text.count(old) == 1, old
    return text.replace(old, new)


def positions(diagnostics):
    return [
        (
            diagnostic["range"]["start"]["line"] + 1,
            diagnostic["range"]["start"]["character"] + 1,
            diagnostic["message"],
        )
        for diagnostic in diagnostics
    ]


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_shipped_files_have_no_diagnostics(server, path):
    text = path.read_text(encoding="utf-8")
    assert text.startswith("# yaml-language-server: $schema=")
    folder = path.parent.relative_to(PROCEDURES)
    assert positions(Editor(server, text, folder).diagnostics) == []


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("id: bench-1", "id: bench-1"),
        ("{gain: 0.3 %, offset: 0.02 N·m, drift: 0.02 N·m, nonlinearity: 0.05 %}", "0.5 % FS"),
    ],
)
def test_complete_register_has_no_diagnostics(server, old, new):
    text = edited(REGISTER, old, new)
    assert positions(Editor(server, text).diagnostics) == []
    assert parse_station(text, "s.yaml").model.instruments


@pytest.mark.parametrize(
    ("old", "new"),
    [("measures: force", "measures: forze"), ("k: 2", "k: two"), ("id: LC-3", "idd: LC-3")],
)
def test_mistake_in_the_register_is_reported(server, old, new):
    wrong = edited(REGISTER, old, new)
    assert positions(Editor(server, wrong).diagnostics)


OWN_ANALYSIS = "write-an-analysis"
"""Its procedure names its own analysis, which the shipped schema does not know."""


def pages_with_files():
    for page in (page for page in pages() if page.stem != OWN_ANALYSIS):
        for block in code_blocks(page):
            language = re.match(
                r"(?:# yaml-language.*\n)?rigrunner: (procedure(?=/2)|station(?=/1))", block.code
            )
            if block.language == "yaml" and block.file and language:
                schema = f"# yaml-language-server: $schema=./{language[1]}.schema.json\n"
                yield pytest.param(schema + block.code, id=f"{page.stem}-{block.file}")


MODELINE = PROCEDURE.splitlines(keepends=True)[0]
WIDE = MODELINE + (ROOT / "tests/e2e/language/wide.yaml").read_text(encoding="utf-8")


@pytest.mark.parametrize("text", [PROCEDURE, STATION, WIDE], ids=["procedure", "station", "wide"])
def test_unspoiled_examples_have_no_diagnostics(server, text):
    assert positions(Editor(server, text).diagnostics) == []


@pytest.mark.parametrize("text", list(pages_with_files()))
def test_files_on_pages_have_no_diagnostics(server, text):
    assert positions(Editor(server, text).diagnostics) == []


ERROR_LIMIT = "expected a limit of error with its unit, such as '0.5 % FS'"
QUANTITY = "expected a number with its unit: such as '10 Hz'"

# old part, new part, where the finger points, what is said
WRONG_PROCEDURES = [
    ("settle:", "setle:", "setle:", "Property setle is not allowed."),
    ("acceptance:", "acceptanc:", "acceptanc:", "Property acceptanc is not allowed."),
    ("cycles: 5", "cycles: five", "five",
     "expected a whole number, or $name for a parameter"),
    ("tester.load: $load", "tester.load: 1000", "1000}", QUANTITY),
    ("tester.load: $load", "load: $load", "load: $load", "Property load is not allowed."),
    ("within: 0.05 N·m", "within: 0.05 Nq", "0.05 Nq", QUANTITY),
    ("channel: tester.torque", "channel: torque", "torque, within",
     "expected role.name, such as tester.torque"),
    ("over: $frequencies", "over: [1 Hz, 2]", "2]", QUANTITY),
    ("over: $frequencies", "over: frequencies", "frequencies\n      steps",
     "expected a list, or $name for a parameter"),
    ("max_age: 30 d", "max_age: 30 N", "30 N",
     "expected a number with its unit: s, ms, min, h, d"),
    ("{alpha: 0.05}", "{alfa: 0.05}", "alfa", "Property alfa is not allowed."),
    ("{alpha: 0.05}", "{alpha: 5}", "5}}", "Value is above the exclusive maximum of 0.5."),
    ("        - template_inverse", "        - template_invers", "template_invers\n",
     "Value is not accepted. Valid values:"),
    ("        - energy", "        - energy: {frequency_match: 1 N}", "1 N}",
     "expected a number with its unit: 1, %"),
    ("        - energy", "        - energy: {wind: 1 deg}", "wind:",
     "Property wind is not allowed."),
    ("rule: guard_band_u", "rule: guard", "guard\n",
     'Value is not accepted. Valid values: "guard_band_fraction", "guard_band_u"'),
    ('revision: "A"', "revision: 1", "1\ntitle", 'Incorrect type. Expected "string".'),
    ("title: A test\n", "", "rigrunner: procedure", 'Missing property "title".'),
    ("retries: 2", "retries: 101", "101}", "Value is above the maximum of 100."),
    ("{min: 900 N", "{minimum: 900 N", "minimum", "Property minimum is not allowed."),
    ("marginal: 10 N}", "marginal: 10}", "10}", QUANTITY),
    ("ramp: {drive: tester.load, ", "ramp: {", "ramp: {to", 'Missing property "drive".'),
    ("        - energy", "        - energy: {}\n          as: 1", "1\n      primary",
     'Incorrect type. Expected "string".'),
]  # fmt: skip
WRONG_STATIONS = [
    ("plugin: swing_tester_sim", "plugin: swing_tester_simm", "swing_tester_simm",
     "Value is not accepted. Valid values:"),
    ("settings: {seed: 1}", "settings: {sead: 1}", "sead", "Property sead is not allowed."),
    ("settings: {seed: 1}", "settings: {eccentric: 2}", "2}",
     "expected a number with its unit: m, mm, µm"),
    ("plugin: swing_tester_sim\n    settings: {seed: 1}", "plugin: replay", "tester:\n",
     'Missing property "settings".'),
    ("gain: 0.3 %", "gain: 0.3", "0.3,", ERROR_LIMIT),
    ("accuracy: {gain: 0.3 %, offset: 0.02 N·m, drift: 0.02 N·m, nonlinearity: 0.05 %}",
     "accuracy: 0.5", "0.5\n", ERROR_LIMIT),
]  # fmt: skip


def assert_reported(server, text, place, message):
    before = text[: text.index(place)]
    line, column = before.count("\n") + 1, len(before.rpartition("\n")[2]) + 1
    first = positions(Editor(server, text).diagnostics)[0]
    assert first[2].startswith(message)
    assert first[:2] == (line, column)


@pytest.mark.parametrize(("old", "new", "place", "message"), WRONG_PROCEDURES)
def test_mistake_in_a_procedure_is_reported(server, old, new, place, message):
    assert_reported(server, edited(PROCEDURE, old, new), place, message)


@pytest.mark.parametrize(("old", "new", "place", "message"), WRONG_STATIONS)
def test_mistake_in_a_station_is_reported(server, old, new, place, message):
    assert_reported(server, edited(STATION, old, new), place, message)


STEP = "        - settle: {cycles: 5}\n"


@pytest.mark.parametrize(
    ("old", "new", "label", "words"),
    [
        (STEP, "        - ‸\n" + STEP, "settle", "Waits until the motion is steady"),
        (STEP, "        - se‸\n" + STEP, "sweep", "Sets a drive to a list of set-points"),
        (STEP, "        - settle:\n            ‸\n", "cycles", "Number of cycles of the motion"),
        ("        - energy\n", "        - ‸\n", "energy", "Running torque"),
        (
            "        - energy\n",
            "        - energy:\n            ‸\n",
            "frequency_match",
            "Default: 2 %",
        ),
        ("outliers: {grubbs: {alpha: 0.05}}", "outliers: ‸", "grubbs", "Grubbs' test"),
        ("primary: template_inverse", "primary: ‸", "energy", "Running torque"),
        ("acceptance:", "‸\nacceptance:", "description", "Purpose and method"),
    ],
)
def test_completions_have_their_help(server, old, new, label, words):
    completions = Editor(server, edited(PROCEDURE, old, new)).completions()
    assert words in str(completions[label]["documentation"])


def test_plugin_is_completed_with_and_without_settings(server):
    editor = Editor(server, edited(PROCEDURE, "        - energy\n", "        - ‸\n"))
    items = server.completions(editor.path, *editor._cursor)
    inserted = {item["insertText"].split("\n")[0] for item in items}
    assert {"energy", "energy:"} <= inserted


def test_completion_of_a_step_inserts_its_required_keys(server):
    completions = Editor(server, edited(PROCEDURE, STEP, "        - ‸\n")).completions()
    inserted = completions["zero"]["textEdit"]["newText"]
    assert re.search(r"channel: .*\n\s+within: ", inserted)
    assert "duration" not in inserted


def test_settings_of_the_chosen_device_are_completed(server):
    text = edited(STATION, "settings: {seed: 1}", "settings:\n      ‸")
    completions = Editor(server, text).completions()
    assert "drive_line" in completions
    assert "manifest" not in completions


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("settle: {", "set‸tle: {", "Waits until the motion is steady"),
        ("max_age: 30 d", "max‸_age: 30 d", "Default: 8 h"),
        ("paper_peak: {", "paper‸_peak: {", "as published"),
        (
            "        - template_inverse",
            "        - template‸_inverse",
            "resonance and filter undone",
        ),
        ("analysis:\n", "anal‸ysis:\n", "Analyses of the recorded data"),
    ],
)
def test_hover_explains_keys_and_names(server, old, new, words):
    assert words in Editor(server, edited(PROCEDURE, old, new)).hover()
