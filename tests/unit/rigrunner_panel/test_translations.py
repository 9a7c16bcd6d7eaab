"""Every English sentence of the program has a German text in one table."""

from __future__ import annotations

import ast
import itertools
import json
import re
import shutil
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

import pytest
import yaml

import rigrunner
from helpers_lacking import lacking
from rigrunner.api.errors import InvalidFileError
from rigrunner.api.quantity import parse_quantity
from rigrunner.api.unit_tables import KINDS
from rigrunner.api.units import with_article
from rigrunner.procedure.answers import AnswerError, Expected
from rigrunner.run.locate import find_procedure, find_station
from rigrunner.run.planning import planned_run
from rigrunner.steps.ask import Ask
from rigrunner.steps.confirm import Confirm
from rigrunner_bearings.compensations.checks import LIMITS as METHOD_LIMITS
from rigrunner_bearings.torque.checks import LIMITS
from rigrunner_bearings.torque.one_setup import LIMITS as SETUP_LIMITS
from rigrunner_panel.jobs.preflight_calibrations import calibrations
from rigrunner_panel.jobs.preflight_rig import rig_items
from unit.rigrunner_panel.helpers_node import running_node

if TYPE_CHECKING:
    from collections.abc import Iterator

UNKNOWN = "Q"
"""Stands in a sentence for a value that is known only at run time."""
_HELP = {"description", "help", "example", "trial", "json_schema_extra"}
"""Shown by the schema and by lists of plugins, in English."""
_A_SENTENCE = re.compile(r"[a-z]{2}")


def nodes_of(path: Path) -> list[ast.AST]:
    return list(ast.walk(ast.parse(path.read_text(encoding="utf-8"))))


@cache
def sentences(path: Path) -> list[tuple[int, str]]:
    """Return line and text of each sentence that a module shows to people."""
    nodes = nodes_of(path)
    skipped = {node.value for node in nodes if isinstance(node, ast.Expr)}  # docstrings
    for node in nodes:
        if isinstance(node, ast.JoinedStr):
            skipped |= {*ast.walk(node)} - {node}
        match node:
            case ast.keyword(arg=name) if name in _HELP:
                skipped |= {*ast.walk(node)}
            case ast.Call(func=ast.Name(id="quantity")):  # of a setting, with its help
                skipped |= {*ast.walk(node)}
    return [
        (node.lineno, text)
        for node in nodes
        if isinstance(node, (ast.Constant, ast.JoinedStr)) and node not in skipped
        for text in _texts(node)
        if " " in text.strip() and _A_SENTENCE.search(text)
    ]


def _texts(node: ast.AST) -> list[str]:
    """Return all texts that a literal may have."""
    match node:
        case ast.Constant(value=str(text)):
            return [text]
        case ast.JoinedStr(values=values):
            return ["".join(parts) for parts in itertools.product(*map(_texts, values))]
        case ast.FormattedValue(value=ast.IfExp(body=body, orelse=other)):
            return [*_texts(body), *_texts(other)]
        case ast.FormattedValue(value=ast.Constant() | ast.JoinedStr() as value):
            return _texts(value)
    return [UNKNOWN]


ROOT = Path(rigrunner.__file__).parent
PANEL = ROOT.parent / "rigrunner_panel"
PLUGINS = ROOT.parents[1] / "plugins"
STATIC = PANEL / "static"
ENGLISH = json.loads((STATIC / "texts/en.json").read_text(encoding="utf-8"))
GERMAN = json.loads((STATIC / "texts/said.de.json").read_text(encoding="utf-8"))
"""German sentences by English ones, for each part of the program."""
ADVICE = [t for key, t in ENGLISH.items() if key.startswith("instead.") and key.endswith(".of")]
"""Advice of the command line that the panel words differently."""
SAYS = [*ADVICE, *itertools.chain.from_iterable(GERMAN.values())]
CHECKER = [
    *(
        str(path.relative_to(ROOT))
        for folder in ("yamlfile", "procedure", "station", "plan", "steps", "signal/expression")
        for path in sorted((ROOT / folder).glob("*.py"))
    ),
    *(f"api/{name}.py" for name in (
        "accuracy", "calibration", "conditions", "filters", "fit_choice", "instruments", "labels",
        "member", "places", "plugin_refs", "quantity", "settings", "texts",
    )),
    "interlock.py",
    *(
        f"../../plugins/{path.relative_to(PLUGINS)}"
        for folder in ("rigrunner_plugins/analyses", "rigrunner_plugins/fits",
                     "rigrunner_plugins/devices", "rigrunner_bearings/devices")
        for path in sorted((PLUGINS / folder).rglob("settings.py"))
    ),
    *(f"../../plugins/rigrunner_plugins/{name}.py" for name in (
        "analyses/equation/kinds", "analyses/equation/text", "devices/declared",
        "devices/composite/routes",
    )),
    *(f"../../plugins/rigrunner_bearings/api/{name}.py" for name in ("measurand", "rig")),
    *(f"../../plugins/rigrunner_bearings/torque/{name}.py" for name in (
        "contradictions", "planning", "requirements_of_plan", "requirers", "settings",
    )),
]  # fmt: skip
"""Modules that report problems of a procedure or a station."""
SILENT = {  # modules of the panel with texts for the terminal or for programs that use the API
    "serve.py", "openapi.py", "operations.py", "requests.py", "answers.py", "app.py", "security.py",
    "commands/__init__.py", "commands/panel.py",
}  # fmt: skip
SPEAKERS = [
    *CHECKER,
    *sorted(
        f"../{path.relative_to(ROOT.parent)}"
        for path in PANEL.rglob("*.py")
        if not path.as_posix().endswith(tuple(SILENT))
    ),
    "engine/breaks.py", "engine/interlocks.py",
    "engine/watching.py", "run/calibration.py", "run/partners.py",
    "run/rig_lock.py", "queue/intake.py", "queue/store.py",
    *sorted(f"documents/verifying/{path.name}" for path in ROOT.glob("documents/verifying/*.py")),
    *(f"documents/certifying/{name}.py" for name in (
        "amend", "certify", "office", "original", "sign",
    )),
    "certificate/order.py", "certificate/withdrawal.py",
    *(f"../rigrunner_fleet/{name}.py" for name in (
        "monitoring/observing", "monitoring/trending", "trends/charting",
        "trends/charts", "trends/rules",
    )),
]  # fmt: skip
PIECES = {  # of sentences that are not assembled as their patterns look
    "Scan Q Q, reading Q", "; or start with", "enter it; Q", "Q, and the baseline is the first Q",
    "found energised: Q; made safe, read back now: Q",
    "add it here: 'uses: {Q: Q}'", "Q N to Q N",
    "enter its accuracy: {channel: ", ", measures: ..., accuracy: ...}", "takes Q, not Q",
    "; a slope over a channel or set-point is a result of the analysis 'curve'",
    "rate is 'Q', expected Q rate above 0", "reading Q: the part 'Q' has no reading",
    "set it before, such as 'set: {Q: 0 N}'", "record an angle, such as Q.angle",
    "record the angle of rotation, such as Q.angle", ", with the rule 'Q',",
    "a quantity with broken powers of its unit", "a quantity of no known unit",
}  # fmt: skip
NAMES = {  # of things and threads, and texts that are only in the log
    "panel client Q", "the Q of Q", "zero Q", "interlock Q",
    "from the rig's process",
    *(f"Nelson {number}" for number in range(1, 9)),
    *(f"Western Electric {number}" for number in range(1, 5)),
    "to the panel", "take over", "another program",
    "a bug in the panel: the screen may be wrong, the run is not",
    "a bug in the panel: the queue has stopped",
    *("nesting depth", "mapping values", "end of stream"),  # words of PyYAML
    "no mapping at Q",  # for programs
    "rigrunner.api.instruments.Q is now Instrument; the old name will be removed in 0.3",
    *("5 deg", "2 mm", "45 mm", "0.002 kg·m²", "0.3 N·m·s/rad"),
    *("Q per Q, within Q", "reading of Q", "Q, order Q, Q HzQ", ", Q dB ripple"),
    *("FIR of Q taps at Q Hz", "measured up to Q Hz (Q)"),  # in a budget of uncertainty
    *("unit Q at Q", "unit Q at Q:Q", "tcp:Q:Q/unit Q", "for Q, a line", "of the channel"),
    *("wrong frequency", "dropped blocks", "repeated block", "wrong order", "hidden gap"),
    *("time back", "quantity in the channel's unit"),  # faults of simulated devices
    "a class of PyMeasure such as pymeasure.instruments.keithley.Keithley2000",  # for an editor
    *("a property such as voltage or ch_1.voltage", "a name such as shutdown"),
    *("a port such as /dev/ttyUSB0 or COM3", "@py, @ivi or FILE.yaml@sim"),
    ("a VISA name such as TCPIP::192.168.0.7::5025::SOCKET, ASRL/dev/ttyUSB0::INSTR or"
     " GPIB0::12::INSTR"),
    "a number, with the parameter's unit where it has one",
}  # fmt: skip


def shape(pattern: str) -> str:
    """Return an expression for texts of a pattern whose places are not filled yet."""
    places = {"quantity": "(?:an? )?Q", "list": r"(?:Qs?|[\w, ]+)", "": r"(?:Q(?: \S+)?|\w+)"}
    places |= dict.fromkeys(("said", "got", "all", "any"), r"(?:Qs?|\w+)")
    pieces = re.split(r"\{([a-z]+)\d*\}", pattern)
    pieces[::2] = map(re.escape, pieces[::2])
    pieces[1::2] = [places.get(kind, places[""]) for kind in pieces[1::2]]
    return "".join(pieces)


SHAPES = re.compile("|".join(map(shape, SAYS)))


def parts(text: str) -> list[str]:
    """Return the fixed parts of a sentence or of a piece of one."""
    pieces = [piece.strip() for piece in re.split(rf"{UNKNOWN}|\{{\w+\}}", text)]
    return [piece for piece in pieces if re.search("[a-z]", piece)]


def is_piece(text: str) -> bool:
    """Return whether its fixed parts are in one sentence that has a German text."""
    inside = ".*".join(rf"(?<![a-z]){re.escape(piece)}(?![a-z])" for piece in parts(text))
    return re.search(inside, "\n".join(SAYS)) is not None


@pytest.mark.parametrize("module", SPEAKERS)
def test_every_sentence_of_the_server_has_a_german_text(module):
    unknown = [
        f"{module}:{line}: {text!r} has no German text in static/texts/said.de.json"
        for line, text in sentences(ROOT / module)
        if text not in PIECES | NAMES and not SHAPES.fullmatch(text) and not is_piece(text)
    ]
    assert unknown == []


def texts_of(path: Path) -> Iterator[str]:
    """Yield all texts of a module, in all their variants."""
    nodes = nodes_of(path)
    inner = {
        part for node in nodes if isinstance(node, ast.JoinedStr)
        for part in ast.walk(node) if part is not node
    }  # fmt: skip
    for node in nodes:
        if node not in inner and isinstance(node, (ast.Constant, ast.JoinedStr)):
            yield from _texts(node)


@pytest.mark.thorough
def test_every_sentence_of_the_table_is_still_used():
    """Half of the longest run of words of each is enough: many sentences are assembled."""
    folders = ("runner", "plugins", "reports")
    modules = [path for name in folders for path in (ROOT.parents[1] / name).rglob("*.py")]
    files = [
        path for name in (*folders, "procedures", "stations")
        for path in (ROOT.parents[1] / name).rglob("*.yaml")
    ]  # fmt: skip
    texts = [text for module in modules for text in texts_of(module)]
    everything = "\n".join([*texts, *(file.read_text(encoding="utf-8") for file in files)])

    def is_used(sentence: str) -> bool:
        words = max((piece.split() for piece in re.split(r"\{\w+\}", sentence)), key=len)
        half = max(len(words) // 2, 1)
        runs = (" ".join(words[at : at + half]) for at in range(len(words) - half + 1))
        return any(run.strip("':;,.() ") in everything for run in runs)

    foreign = GERMAN["words of PyYAML and of the system"]
    assert [text for text in SAYS if text not in foreign and not is_used(text)] == []


def test_every_exception_is_still_used():
    texts = {text for module in SPEAKERS for _, text in sentences(ROOT / module)}
    assert texts >= PIECES | NAMES


@pytest.fixture(scope="module")
def translate(tmp_path_factory):
    """Return a function that translates English sentences with the screen's own code."""
    if shutil.which("node") is None:
        lacking("BROWSER", "there is no Node.js")
    folder = tmp_path_factory.mktemp("said")
    for name in ("said", "format"):
        shutil.copy(STATIC / f"js/{name}.js", folder / f"{name}.mjs")
    for name in ("en", "de", "said.de"):
        shutil.copy(STATIC / f"texts/{name}.json", folder)
    program = """
      import fs from 'fs';
      import { shownNumber, useDecimalSign } from './format.mjs';
      import { translator } from './said.mjs';
      const read = (name) => JSON.parse(fs.readFileSync(name));
      useDecimalSign(',');
      const say = translator(
        read('said.de.json'), read('en.json'), read('de.json'), shownNumber);
      const answer = (texts) => texts.map((text) => say(text));
    """
    with running_node(folder, program) as ask:
        yield lambda *texts: ask(texts)


@pytest.mark.parametrize(
    ("english", "german"),
    [
        ("Set tester.load to 1000 N", "tester.load auf 1000 N setzen"),
        ("Wait for 300 s: warm up", "300 s warten: warm up"),
        ("Settle for 1 cycle (0.2 s)", "1 Zyklus einschwingen lassen (0,2 s)"),
        (
            "B-101 is already in the queue: entry 2, held",
            "B-101 steht schon in der Warteschlange: Eintrag 2, zurückgestellt",
        ),
        ("type GE20, lot L-1", "Typ GE20, Los L-1"),
        (
            "type GE20, lot L-1: there is 1 value, and the baseline is the first 10",
            "Typ GE20, Los L-1: es gibt 1 Wert, die Grundlage sind die ersten 10",
        ),
        (
            "type not stated, lot not stated, bench.pressure = 2 Pa",
            "Typ nicht angegeben, Los nicht angegeben, bench.pressure = 2 Pa",
        ),
        ("procedure PG-CAL, bench.pressure = 2 Pa", "Verfahren PG-CAL, bench.pressure = 2 Pa"),
        (
            "bench cannot pause: pressure stays at 2 Pa",
            "bench kann nicht pausieren: pressure bleibt auf 2 Pa",
        ),
        ("Load-induced starting torque", "Lastinduziertes Anlaufmoment"),
        (
            "SN-1 has already been tested: run 20261128T215718Z_QUICK-ST_SN-1",
            "SN-1 wurde schon geprüft: Prüfung 20261128T215718Z_QUICK-ST_SN-1",
        ),
        ("65.2 GB free, the run needs 1.1 MB", "65,2 GB frei, die Prüfung braucht 1,1 MB"),
        ("see GET /api/v1/runs", "neu laden und noch einmal wählen"),
        (
            "Scan tester.load between 10 N and 1 kN, 9 points, reading tester.load, a.b",
            "tester.load zwischen 10 N und 1 kN durchfahren, 9 Punkte, tester.load, a.b lesen",
        ),
        (
            "tester.load is 1000 N, above 500 N; not cleared yet",
            "tester.load ist 1000 N, über 500 N; noch nicht behoben",
        ),
        (
            "tester.a is 1 N, below 2 N; tester.b cannot be read: no sample came",
            "tester.a ist 1 N, unter 2 N; tester.b ist nicht lesbar: es kam kein Messwert",
        ),
        (
            "revision A: draft, not for certification",
            "Revision A: Entwurf, nicht zur Zertifizierung",
        ),
        (
            "the procedure was changed after its approval by A. Jones on 2026-01-02",
            "das Verfahren wurde nach der Freigabe durch A. Jones am 2026-01-02 geändert",
        ),
        (
            "TQ-7 (tester.torque) is calibrated up to 10 N·m, but the swing goes to 0.05 rad",
            "TQ-7 (tester.torque) ist bis 10 N·m kalibriert, aber der Schwenk geht bis 0,05 rad",
        ),
        (
            "stopped at the panel: stop button, before the run began",
            "am Bildschirm angehalten: STOPP-Taste, bevor die Prüfung begann",
        ),
        ("load was raised from 900 N to 1000 N", "load: erhöht von 900 N auf 1000 N"),
        ("specimen was changed from 'SN-0' to 'SN-3'", "Prüfling: geändert von 'SN-0' auf 'SN-3'"),
        (
            "verdict was changed from 'pass' to 'no verdict'",
            "Urteil: geändert von 'bestanden' auf 'kein Urteil'",
        ),
        ("the second run alone has a result", "nur die zweite Prüfung hat ein Ergebnis"),
        (
            "state of the procedure was changed from 'draft' to 'approved by A. Jones'",
            "Stand des Verfahrens: geändert von 'Entwurf' auf 'freigegeben von A. Jones'",
        ),
        ("recordings: '001_1Hz' removed", "Aufnahmen: weg fallen '001_1Hz'"),
        (
            (
                "needed: a completed run of QUICK-NL, station 'b-1', mandrel 'M-1', begun within "
                "8 h of this run; run that procedure first, or name a run with --partner "
                "no_load=RUN"
            ),
            (
                "gebraucht wird eine abgeschlossene Prüfung von QUICK-NL, Prüfstand „b-1“, Dorn "
                "„M-1“, höchstens 8 h von dieser entfernt; dieses Verfahren zuerst ausführen"
            ),
        ),
        (
            "'abc' is not a number with a unit; units of force: N, kN",
            "„abc“ ist keine Zahl mit Einheit; Einheiten für Kraft: N, kN",
        ),
        (
            "main: number 2 was removed: {settle: {cycles: 5}}",
            "main: Nummer 2 ist entfallen: {settle: {cycles: 5}}",
        ),
        (
            (
                "at 5 Hz: 0.7261 and 0.7272 N·m: +0.0011 N·m, within their combined U of 0.0120 N·m"
                " (E_n = 0.09)"
            ),
            (
                "bei 5 Hz: 0,7261 und 0,7272 N·m: +0,0011 N·m, innerhalb ihres gemeinsamen U von"
                " 0,0120 N·m (E_n = 0,09)"
            ),
        ),
        (
            (
                "there is no no-load run in runs; looked at and refused: R1: its mandrel is 'a', "
                "but 'b' is needed; R2: other"
            ),
            (
                "in runs fehlt: Leerlaufprüfung; angesehen und verworfen: R1: Dorn „a“ "
                "statt „b“; R2: other"
            ),
        ),
        ("no-load run: clipping", "Leerlaufprüfung: Übersteuerung"),
        (
            "001_1Hz entered 1 Hz, angle says 1.012 Hz; 002_3Hz entered 3 Hz, angle says 3.1 Hz",
            (
                "001_1Hz: eingegeben 1 Hz, nach dem Winkel 1,012 Hz;"
                " 002_3Hz: eingegeben 3 Hz, nach dem Winkel 3,1 Hz"
            ),
        ),
        (
            "001_1Hz swings ±2.700° in place of ±2.547°",
            "001_1Hz: Schwenk ±2,700° statt ±2,547°",
        ),
        (
            "of the no-load run, its full scale is '10 N·m', but '20 N·m' is needed",
            "Leerlaufprüfung: der Messbereichsendwert ist 10 N·m, gebraucht wird 20 N·m",
        ),
        (
            (
                "the no-load torque differs from inertia, resonance and friction by 2.1 times"
                " its scatter"
            ),
            (
                "das Leerlaufmoment weicht um das 2,1fache seiner Streuung von Trägheit, Resonanz"
                " und Reibung ab"
            ),
        ),
        (
            "7.3 % of the torque; 61% of the support's friction is built up",
            "7,3 % des Drehmoments; 61 % der Reibung der Lagerung sind aufgebaut",
        ),
        (
            (
                "+0.012 ± 0.004 N·m on the mean, +0.031 ± 0.010 N·m at 35 Hz;"
                " in the budget as 'coupling'"
            ),
            (
                "+0,012 ± 0,004 N·m im Mittelwert, +0,031 ± 0,010 N·m bei 35 Hz;"
                " im Unsicherheitsbudget als „Kupplung“"
            ),
        ),
        ("load-induced starting torque", "lastinduziertes Anlaufmoment"),
        ("DOES NOT MATCH: 2 differences", "STIMMT NICHT ÜBEREIN: 2 Unterschiede"),
        (
            "REPLACED: S-1 is no longer in force: S-2 replaced it",
            "ERSETZT: S-1 gilt nicht mehr: S-2 hat es ersetzt",
        ),
        (
            "OPEN: nothing differs, but not all could be checked",
            "OFFEN: nichts weicht ab, aber nicht alles ließ sich prüfen",
        ),
        ("DOES NOT MATCH: 1 difference", "STIMMT NICHT ÜBEREIN: 1 Unterschied"),
        (
            (
                "bytes of run.h5: SHA-256 ab, and the certificate names cd; its differences are"
                " listed above"
            ),
            "Bytes von run.h5: SHA-256 ab, das Zertifikat nennt cd; die Abweichungen stehen oben",
        ),
        (
            "Rigrunner: 0.1.0 when it was issued, 0.2.0 now",
            "Rigrunner: 0.1.0 bei der Ausstellung, jetzt 0.2.0",
        ),
        (
            "S-1.pdf regenerated from its content: it shows '7.2', its content does not",
            "S-1.pdf aus seinem Inhalt neu erstellt: es zeigt „7.2“, der Inhalt nicht",
        ),
        (
            "compensation 'energy' revision 2, not installed; version 0.1.0 recomputes them",
            "compensation 'energy' Revision 2, nicht installiert; Version 0.1.0 rechnet sie nach",
        ),
        (
            "signed by Ann at 2026-01-02T03:04:05Z, key SHA256:ab, which is trusted",
            (
                "unterschrieben von Ann am 2026-01-02T03:04:05Z, Schlüssel SHA256:ab, dem vertraut"
                " wird"
            ),
        ),
        (
            "no chart can be made. all runs: there are 8 values, and the baseline is the first 20",
            (
                "keine Karte möglich. alle Prüfungen: es gibt 8 Werte,"
                " die Grundlage sind die ersten 20"
            ),
        ),
        (
            "no no-load recording within 2.0% of 10.5 Hz (live); the no-load run has 10 Hz, 20 Hz",
            (
                "keine Leerlaufaufnahme innerhalb 2.0 % von 10.5 Hz (live); die Leerlaufprüfung hat"
                " 10 Hz, 20 Hz"
            ),
        ),
        (
            (
                "template_inverse is not applicable: no no-load recording within 2.0% of 5.5 Hz"
                " (watched); the no-load run has 10 Hz"
            ),
            (
                "template_inverse ist nicht anwendbar: keine Leerlaufaufnahme innerhalb 2.0 % von"
                " 5.5 Hz (watched); die Leerlaufprüfung hat 10 Hz"
            ),
        ),
        ("torque", "Drehmoment"),
        ("'rigrunner archive search' shows runs", "Verlauf zeigt die Prüfungen"),
        (
            "--received 2030-01-01 is after the test, which began on 2026-01-02 (UTC)",
            "liegt nach der Prüfung, die am 2026-01-02 (UTC) begann",
        ),
        ("--received: 'x' is not a date", "'x' is not a date"),
        (
            "'10 N·m' is a torque; speed is an angular velocity, in rad/s",
            "„10 N·m“ passt nicht (Drehmoment); speed: Winkelgeschwindigkeit, in rad/s",
        ),
        (
            "there is a result 'torque' for each load and speed",  # names stay as they are
            "das Ergebnis „torque“ gibt es je load und speed",
        ),
        (
            (
                "expected t.load up to 500 N with t.frequency up to 35.5 Hz or t.load up to 1 kN"
                " with t.frequency up to 5 Hz; it is written at p.yaml:11:23"
            ),
            (
                "erwartet: t.load bis 500 N mit t.frequency bis 35,5 Hz oder t.load bis 1 kN mit"
                " t.frequency bis 5 Hz; es steht in p.yaml:11:23"
            ),
        ),
        (
            "got a list of 2, expected a text or a number or true or false",
            (
                "eine Liste mit 2 Einträgen steht hier,"
                " erwartet: ein Text oder eine Zahl oder true oder false"
            ),
        ),
        ("got 'nothing', expected a list", "'nothing' steht hier, erwartet: eine Liste"),
        ("roles: none", "Rollen: keine"),
        (
            "the unattended answer: 'warm' is not a number with a unit",
            "die Antwort für den unbeaufsichtigten Betrieb: „warm“ ist keine Zahl mit Einheit",
        ),
        (
            "last set-points: psu.voltage 40 V; nothing has confirmed since that it is safe",
            "letzte Sollwerte: psu.voltage 40 V; seither hat nichts bestätigt, dass er sicher ist",
        ),
        (
            (
                "the analysis, with the rule 'grubbs', needs at least 12 cycles in each recording,"
                " got 3 at 1.5 Hz"
            ),
            (
                "die Auswertung mit der Regel „grubbs“ braucht mindestens 12 Zyklen je"
                " Aufzeichnung, vorhanden: 3 bei 1,5 Hz"
            ),
        ),
        (
            (
                "the limit is for the no-load torque from rest, and the result is the load-induced"
                " torque under way under 1000 N"
            ),
            (
                "der Grenzwert gilt für eine andere Messgröße (Leerlaufmoment aus der Ruhe) als"
                " das Ergebnis (lastinduziertes Drehmoment in der Bewegung unter 1000 N)"
            ),
        ),
        (
            (
                "/lab/ab.yaml:34:17: rig.full_scale: got '10 N', a force, expected a torque\n"
                "/lab/s.yaml:9:1: load: '5 N' is a force, not a time (units of time: s, min)"
            ),
            (
                "/lab/ab.yaml:34:17: rig.full_scale: „10 N“ passt nicht (Kraft), erwartet:"
                " Drehmoment\n"
                "/lab/s.yaml:9:1: load: '5 N' passt nicht: Kraft statt Zeit (Einheiten für Zeit:"
                " s, min)"
            ),
        ),
        (
            "There is no value of R at load.current = 0 A: 'U / I' gives no finite number.",
            "Es gibt keinen Wert von R bei load.current = 0 A: „U / I“ ergibt keine endliche Zahl.",
        ),
        (
            "'torque' is the total torque from rest, and the key 'measurand' is missing",
            (
                "„torque“ ist eine bestimmte Messgröße (gesamtes Drehmoment aus der Ruhe), und der"
                " Schlüssel „measurand“ fehlt"
            ),
        ),
        (
            "state it by the keys nature, condition",
            "mit den Schlüsseln nature, condition angeben, für welche der Grenzwert gilt",
        ),
        ("load is an issue", "load is an issue"),  # no kind of quantity
        ("the motor is hot", "the motor is hot"),  # of a device: not translated
        ("the drive has no power", "the drive has no power"),
        ("", ""),
    ],
)
def test_sentence_is_translated_completely_or_not_at_all(translate, english, german):
    assert translate(english) == [german]


CHECKS = [
    "plugins/rigrunner_bearings/torque/checks.py",
    "plugins/rigrunner_bearings/torque/one_setup.py",
    "plugins/rigrunner_bearings/torque/consistency.py",
    "plugins/rigrunner_bearings/compensations/checks.py",
    "runner/rigrunner/api/checks.py",
]
PIECES_OF_CHECKS = {  # assembled with others, or not shown at the panel
    "nowhere Q or more equal samples at the extreme", "at least Q samples in every cycle",
    "Q entered Q Hz, Q", "angle says", "tacho says", "index pulses say", "torque repeats at",
    "Qangle channel", "not stated", "Q mm", "torque transducer", "transducer's certificate",
    "full scale", "low-pass filter", "its Q is Q, but Q is needed", "Q, the most of all",
    "Q Hz is off their trend by Q N·m", "repeatability, loaded", "repeatability, no load",
    "the no-load torque differs from inertia, resonance and friction by Q times", "Q its scatter",
    "of the no-load run, Q", " in place of ±Q°", "not checked: ", "in the budget as '{name}'",
    "gain and inertia between the runs", "Q to QQ", "above 0Q", "at least QQ", "at most QQ",
    "Q on the mean", "its effect cannot be estimated; Q",
    "Q of the inertia's torque is left, Q may be chance",
    "The check 'Q' failed: QQQ.",
}  # fmt: skip


def test_texts_of_failing_checks_are_translated(translate):
    """Each sentence with numbers in its places; those above are assembled with others."""
    texts = [
        text.replace("Q", "12")
        for module in CHECKS
        for _, text in sentences(ROOT.parents[1] / module)
        if text not in PIECES_OF_CHECKS
    ]
    assert len(texts) > 100
    assert [
        text for text, german in zip(texts, translate(*texts), strict=True) if german == text
    ] == []


def answers():
    """Messages about wrong answers, and the answers that are allowed."""
    low, high = parse_quantity("15 °C"), parse_quantity("30 °C")
    for limits in ({}, {"minimum": low}, {"maximum": high}, {"minimum": low, "maximum": high}):
        expected = Expected(unit="°C", **limits)
        yield expected.words
        for wrong in ("warm", "5 ", "41", "23 N", "22,5", "1,000 K", "1 2 K", "1 quux", "1e999 K"):
            try:
                expected.accept(wrong)
            except AnswerError as error:
                yield from (error.message, error.hint)
    for wrong in ("lef", "\0"):
        try:
            Expected(choices=("left", "right")).accept(wrong)
        except AnswerError as error:
            yield from (error.message, error.hint)


def plans():
    """Steps of shipped procedures, and the items of their preflight."""
    station = find_station("simulated")
    for name in ("no_load_inertia_sweep", "starting_torque_1000n"):
        planned = planned_run(find_procedure(name), station)
        free_texts = (Confirm, Ask)
        steps = (step for step in planned.plan.steps if not isinstance(step.action, free_texts))
        yield from (step.text for step in steps)
        yield from (item.text for item in (*calibrations(planned), *rig_items(planned)))


def assembled_texts():
    """Texts assembled from pieces that do not occur above."""
    yield from (
        "Ramp tester.load to 1 kN in 10 s",
        "Measure tester.load, tester.temperature, once",
        "Measure tester.load, mean over 2 s",
        "Scan tester.load between 10 N and 1 kN, 9 points, reading tester.load, tester.angle",
        "Scan tester.load at 10 N, 1 point, reading tester.load",
        "Record angle of tester, for a time (3 s)",
        "tester.load may be set to 0 to 3000 N",
        "tester.load is 20 N again",
        "the process of the run ended with code 9",
        "the process of the run ended without a word",
        "main[1]: aborted while paused: wrong bearing",
        "the calibration of TQ-7 (tester.torque) was due on 2021-01-01, 1 day before this run",
        "TQ-7 (tester.torque) is calibrated up to 2 N·m, but recording 1 is expected to reach 3",
        "TQ-7 (tester.load) is calibrated from 1 N to 2 N, but tester.load is set to 3 N",
        "enter it; or start with --override tester.torque --by NAME --reason TEXT",
        "there is no no-load run in my runs; looked at and refused: R1: it is old; R2: other",
        "the rig of station bench-1 is in use: SSPB-NLI, process 77, since 2026-01-02T03:04:05Z",
    )


def checks():
    """Name, text of success and advice of every check."""
    for check in (*LIMITS, *SETUP_LIMITS, *METHOD_LIMITS):
        yield from (check.name, check.good, check.advice)


def names_of_devices():
    """Names of the channels and drives of shipped devices."""
    for name in ("no_load_inertia_sweep", "loaded_breakaway"):
        station = find_station("simulated" if name.startswith("no") else "simulated_loaded_bench")
        for device in planned_run(find_procedure(name), station).devices.values():
            yield from (channel.long_name for channel in device.channels)
            yield from (drive.long_name for drive in getattr(device, "drives", ()))


SPOILED = {
    "id: SSPB-STT-1000": "id: a b",
    "title: ": "titel: ",
    'revision: "A"': "revision: 1.0",
    "setup:\n": "setup: 3\n",
    "main:\n": "main:\n  - settel: {cycles: 3}\n  - settle: {cycles: 3}\n    wait: {time: 1 s}\n",
    "- settle: {cycles: 100}": "- settle: {cycle: 100}\n  - wait: {time: 5}\n  - wait: {time: 5 N}",
    "$load": "$lode",
    "uses: {tester: swing_tester}": "uses: {teste: swing_tester}",
    "main:": "main: &a",
    "measurand:": "measurands:",
    "rigrunner: procedure/2": "rigrunner: station/1",
    "load: 1000 N": "load: 7000 N",
    "\n  - confirm:": "\n\t- confirm:",
    "swing_torque:": "swing_torqe:",
}
"""Mistakes in a text: what is right, and what is wrong."""


def problems_of_a_text():
    """Problems that the editor reports for a wrong text."""
    path, station = find_procedure("starting_torque_1000n"), find_station("simulated")
    text = path.read_text(encoding="utf-8")
    for right, wrong in SPOILED.items():
        assert right in text
        try:
            planned_run(path, station, text=text.replace(right, wrong, 1))
        except InvalidFileError as error:
            for problem in error.problems:
                yield from (problem.message, problem.hint)


def quantities():
    """Every kind of quantity."""
    yield from (f"'1' is {with_article(name)}, not a force" for name, *_ in KINDS)


SPOILED_STATION = {
    "eccentric: 2 mm": "eccentric: 50 mm",
    "title: ": "titel: ",
    "mandrel: M-01": "mandrel: 5",
    "plugin: swing_tester_sim": "plugin: swing_tester_smi",
    "{seed: 1}": "{seed: 1.5, sede: 2}",
    "order: [tester.frequency": "order: [tester.frequncy",
    "order: [": "drives: {tester.load: {max: 5 Hz}}\n  order: [",
    "  interlocks:": "  combinations: [{allowed: [{tester.load: 5 N, x.y: 1 Hz}]}]\n  interlocks:",
    "above: 60 °C": "above: 60 N",
    "channel: tester.temperature": "channel: tester.temprature",
    "calibration: simulated": "calibration: real",
    "full_scale: 10 N·m": "full_scale: 10 N",
    "gain: 0.3 %": "gain: 0.3 N·m",
    "corner: 1 kHz": "corner: 1 Nm",
    "channel: tester.torque": "channel: torque",
    "drift: 0.02 N·m": "drift: 0.02 N",
}
"""The same for a station."""


def problems_of_a_station():
    """Problems that the preflight reports for a wrong station."""
    procedure, good = find_procedure("starting_torque_1000n"), find_station("simulated")
    text = good.read_text(encoding="utf-8")
    for right, wrong in SPOILED_STATION.items():
        assert right in text
        with TemporaryDirectory() as folder:
            station = Path(folder) / "station.yaml"
            station.write_text(text.replace(right, wrong, 1), encoding="utf-8")
            try:
                planned_run(procedure, station)
            except InvalidFileError as error:
                for problem in error.problems:
                    yield from (problem.message, problem.hint)


def names_in_procedures():
    """Inputs, measurands and results of shipped procedures."""
    for path in sorted(Path(find_procedure("gauge_rr")).parent.glob("*.yaml")):
        procedure = yaml.safe_load(path.read_text("utf-8"))
        yield from (definition["ask"] for definition in procedure.get("inputs", {}).values())
        yield procedure.get("measurand", {}).get("name", "")
        yield from re.findall(r"result: {.*?text: (.*?)[,}]", path.read_text("utf-8"))


@pytest.mark.parametrize(
    "source",
    [
        answers,
        plans,
        assembled_texts,
        checks,
        names_in_procedures,
        problems_of_a_text,
        problems_of_a_station,
        quantities,
        names_of_devices,
    ],
)
def test_texts_in_use_are_translated(translate, source):
    texts = [text for text in source() if text]
    assert len(texts) > 10
    pairs = zip(texts, translate(*texts), strict=True)
    unchanged = {text for text, german in pairs if text == german}
    assert unchanged <= {"in °C"}  # the same in both languages
