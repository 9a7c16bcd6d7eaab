"""One mistake in a plugin gives one failed check, which says what to change and where.

Each case starts from a plugin of `rigrunner new` and makes one mistake, as newcomers do.
"""

from __future__ import annotations

import json
import re
from importlib import import_module
from importlib.metadata import EntryPoint

import pytest

from helpers_cli import call
from rigrunner.registry import load_registry, with_drop_ins
from rigrunner.tools.new_plugin import new_plugin
from rigrunner_testing import State, checks, examine, subject

SIMULATOR = "    simulator = SimulatedSpring\n"
GET = '        return float(self.ask(f"{channel.upper()}?"))\n'
PUT = '        self.ask(f"{drive.upper()} {value}")\n'
WHOLE_PUT = f'''\
    def put(self, drive: str, value: float) -> None:
        """Give a drive a new set-point."""
{PUT}'''
CHANNELS = '(ChannelInfo("force", "N", "Force"),)'
BEGINNING = "\n\nclass SimulatedSpring"
SOCKET = ("from rigrunner.api import", "import socket\n\nfrom rigrunner.api import")
OPENED = 'socket.create_connection(("127.0.0.1", 9), 0.5)'


def init(*lines, given="self, settings, context"):
    """Return the edit that gives the class its own constructor."""
    body = "".join(f"        {line}\n" for line in lines)
    return (SIMULATOR, f"{SIMULATOR}\n    def __init__({given}):\n{body}")


def method(text):
    return (SIMULATOR, f"{SIMULATOR}\n{text}")


def setting(line):
    """Return the edits that give the plugin its own settings, with this line."""
    own = f'\n\nclass Own(LineSettings):\n    """Own."""\n\n    {line}\n{BEGINNING}'
    return [(BEGINNING, own), ("settings=LineSettings", "settings=Own")]


SUPER = "super().__init__(settings, context)"
DEVICE = {
    "a unit that is not SI": (
        [('"N", "Force")', '"kN", "Force")'), ('"N", "Force", min', '"kN", "Force", min')],
        ["is in 'kN', expected the coherent SI unit, N", "correct Spring (", "spring.py:20)"],
    ),
    "a unit that is none": (
        [('"N", "Force")', '"Newton", "Force")')],
        ["force is in 'Newton'; that is not a known unit"],
    ),
    "a tuple of one without its comma": (
        [(CHANNELS, CHANNELS.replace(",)", ")"))],
        ["channels is one ChannelInfo", "a comma: `channels = (ChannelInfo(...),)`"],
    ),
    "channels that are names": (
        [(CHANNELS, '["force"]')],
        ["channels has 'force', expected a tuple of ChannelInfo"],
    ),
    "a channel with too few words": (
        [('"force", "N", "Force")', '"force")')],
        ["missing 2 required positional arguments: 'unit' and 'long_name'", "spring.py:23"],
    ),
    "a name that is given twice": (
        [(CHANNELS, f"{CHANNELS[:-1]} {CHANNELS[1:]}")],
        ["channel 'force': the name is given twice", "spring.py:20"],
    ),
    "minimum and maximum swapped": (
        [("minimum=0.0, maximum=1000.0", "minimum=1000.0, maximum=0.0")],
        ["drive 'force': its limits are 1000.0 and 0.0, expected", "the lower one first"],
    ),
    "limits as text": (
        [("minimum=0.0", 'minimum="0 N"')],
        ["its limits are 0 N and 1000.0, expected two finite numbers"],
    ),
    "a safe value beyond the limits": (
        [("minimum=0.0", "minimum=10.0")],
        ["drive 'force': its safe value is 0, and its limits are 10.0 and 1000.0"],
    ),
    "a constructor in the wrong order": (
        [init("super().__init__(settings, context)", given="self, context, settings")],
        ["context and settings in the wrong order", "spring.py:27", "(self, settings, context)"],
    ),
    "a constructor that takes nothing": (
        [init("super().__init__()", given="self")],
        ["its factory Spring takes (), and is called with settings, context", "spring.py:27"],
    ),
    "no base class": (
        [("class Spring(LineDriver)", "class Spring")],
        ["its factory Spring takes (), and is called with settings, context"],
    ),
    "no super().__init__": (
        [init("self.settings = settings")],
        ["Spring.__init__ does not call super().__init__()", "spring.py:27"],
    ),
    "raising in the constructor": (
        [init(SUPER, 'raise RuntimeError("no licence")')],
        ["RuntimeError: no licence", "correct", "spring.py:29"],
    ),
    "opening the port in the constructor": (
        [SOCKET, init(SUPER, OPENED)],
        ["making it raises ConnectionRefusedError", "spring.py:31", "in `open` of a Driver"],
    ),
    "opening a socket in the constructor": (
        [
            SOCKET,
            init(
                SUPER,
                "with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as port:",
                '    port.connect(("127.0.0.1", 9))',
            ),
        ],
        ["making it did: socket.connect", "open sockets, ports and threads in `connect`"],
    ),
    "no simulator": (
        [(SIMULATOR, "")],
        ["Spring has no simulator", "write `simulator = ...` into the class"],
    ),
    "a simulator that does not answer": (
        [("def answer(", "def reply(")],
        ["SimulatedSpring, the simulator of Spring, has no method `answer`"],
    ),
    "a simulator that returns nothing": (
        [('        return "Example', '        "Example')],
        ["`answer` of SimulatedSpring gave None to '*IDN?'", "is there a `return`?"],
    ),
    "put misspelt": (
        [("def put(", "def putt(")],
        ["Spring has no `put`: is `putt` meant?", "spring.py:31"],
    ),
    "no put": (
        [(f"\n{WHOLE_PUT}", "")],
        ["Spring has no `put`", "correct Spring (", "spring.py:20)"],
    ),
    "put that sends nothing": (
        [(PUT, "        pass\n")],
        ["force reads back 0 N after 0 s, set to 100 N", "send the set-point in `put` (", ":31)"],
    ),
    "put in another unit": (
        [("{value}", "{value / 1000}")],
        ["force reads back 0.1 N after 0 s, set to 100 N", "in the unit of the DriveInfo"],
    ),
    "async def get": (
        [("    def get(", "    async def get(")],
        ["Spring.get is `async def`", "write `def get`", "spring.py:27"],
    ),
    "get without a channel": (
        [("def get(self, channel: str)", "def get(self)"), ("{channel.upper()}", "FORCE")],
        ["Spring.get takes (), and is called with channel", "spring.py:27"],
    ),
    "get without self": (
        [("def get(self, channel: str)", "def get(channel: str)")],
        ["Spring.get takes (), and is called with channel"],
    ),
    "a str from get": (
        [(GET, '        return self.ask(f"{channel.upper()}?")\n')],
        ["force reads '0.0'", "spring.py:27", "convert the str: `return float(...)`"],
    ),
    "an int from get": (
        [(GET, "        return 0\n")],
        ["force reads 0", "convert the int: `return float(...)`"],
    ),
    "get that forgets to return": (
        [(GET, GET.replace("return ", ""))],
        ["force reads None", "spring.py:27", "is there a `return`?"],
    ),
    "get that gives no number": (
        [(GET, '        return float("nan")\n')],
        ["force reads nan", "expected a finite float"],
    ),
    "a misspelt call in get": (
        [('self.ask(f"{channel', 'self.aks(f"{channel')],
        ["AttributeError: 'Spring' object has no attribute 'aks'", "correct", "spring.py:29"],
    ),
    "a channel that get does not know": (
        [(GET, '        return {"Force": 1.0}[channel]\n')],
        ["KeyError: 'force'", "correct", "spring.py:29"],
    ),
    "get past the wire": (
        [(GET, "        return self._link._instrument.force\n")],
        ["it reads without one exchange over the wire", "through `self.exchange("],
    ),
    "read that gives a list": (
        [method("    def read(self, channels):\n        return [*map(self.get, channels)]\n")],
        ["asked for ['force'], `read` returned [0.0]", "spring.py:27"],
    ),
    "make_safe that gives nothing": (
        [method('    def make_safe(self):\n        self.put("force", 0.0)\n')],
        ["`make_safe` gave None", "spring.py:27", "read each back, and return these"],
    ),
    "identify that gives nothing": (
        [method('    def identify(self):\n        self.ask("*IDN?")\n')],
        ["`identify` of Spring gave None", "return Identity(maker, model, serial, firmware)"],
    ),
    "an identity without a model": (
        [("Example,Model 1,", "Example,,")],
        ["the identity has no model", "fill in `maker`, `model`"],
    ),
    "a syntax error": (
        [("channel: str) -> float:", "channel: str) -> float")],
        ["SyntaxError: expected ':'", "correct", "spring.py:27"],
    ),
    "a module that is not there": (
        [("from rigrunner.api import", "import pyvissa\nfrom rigrunner.api import")],
        ["No module named 'pyvissa'", "spring.py:3", "install the package that brings 'pyvissa'"],
    ),
    "ending the program": (
        [("api_version = 1\n", "api_version = 1\nraise SystemExit(0)\n")],
        ["SystemExit: 0", "spring.py:6"],
    ),
    "no api_version": (
        [("api_version = 1\n", "")],
        ["for which plugin API it is made", "its module needs a line 'api_version = 1'"],
    ),
    "a hook's name misspelt": (
        [("def rigrunner_devices", "def rigrunner_device")],
        ["rigrunner_device (", "is not the name of a hook", "call it rigrunner_devices"],
    ),
    "no hookimpl": (
        [("@hookimpl\n", "")],
        ["rigrunner_devices is not marked as a hook", "put @hookimpl", "spring.py:36"],
    ),
    "a hook that forgets to return": (
        [("    return [\n        DeviceRecord", "    [\n        DeviceRecord")],
        ["rigrunner_devices returned None", "is there a `return`?"],
    ),
    "a hook that returns one record": (
        [("    return [\n", "    return (\n"), ("        )\n    ]", "        )\n    )")],
        ["returned one DeviceRecord, expected a list of DeviceRecord", "put it into a list"],
    ),
    "a name that YAML cannot have": (
        [('name="spring"', 'name="Spring-1"')],
        ["'Spring-1'", "small letters, digits and '_'", "such as 'spring_scale'"],
    ),
    "a factory that is called": (
        [("factory=Spring,", "factory=Spring(),")],
        ["missing 2 required positional arguments: 'settings' and 'context'", "spring.py:44"],
    ),
    "settings that are no class": (
        [("settings=LineSettings,", "settings=LineSettings(simulated=True),")],
        ["no subclass of Settings", "name the class itself, without brackets"],
    ),
    "a record without help": (
        [('            help="Spring, by lines of text",\n', "")],
        ["missing 1 required keyword-only argument: 'help'", "spring.py:40"],
    ),
    "a setting without a type": (
        setting("gain = 5"),
        ["A non-annotated attribute was detected: `gain = 5`", "write the type", "spring.py:8"],
    ),
    "a setting without a word of help": (
        setting("gain: float = 5"),
        ["no word of help on: gain", "write a docstring under the field"],
    ),
}
OTHERS = {
    "fit": {
        "forgetting to return": (
            [("    return SpringCurve(", "    SpringCurve(")],
            ["it gave a NoneType, which has no formula", "is there a `return`?"],
        ),
        "a call that takes nothing": (
            [("def fit(points: Points)", "def fit()"), ("points.", "None.")],
            ["fit takes (), and ", "is called with points", "correct what _make"],
        ),
        "a factory that forgets to return": (
            [("    return fit\n", "    fit\n")],
            ["the factory of the fit 'spring' gave None", "is there a `return`?"],
        ),
        "a factory that takes nothing": (
            [("def _make(_: NoSettings)", "def _make()")],
            ["its factory _make takes ()", "is called with settings"],
        ),
        "a coefficient without its unit": (
            [('units=(points.y_unit, f"{points.y_unit}/{points.x_unit}")', 'units=("N·m",)')],
            ["2 coefficients have 1 units", "one name, one unit"],
        ),
        "a variance for a covariance": (
            [("covariance=(covariance + covariance.T) / 2", "covariance=np.diag(covariance)")],
            ["the covariance has the shape (2,)"],
        ),
        "a crash": (
            [("q, r = np.linalg.qr(columns)", "q, r = np.linalg.qrr(columns)")],
            ["AttributeError", "'qrr'", "correct", "spring.py:"],
        ),
        "a hook of another kind": (
            [("def rigrunner_fits", "def rigrunner_devices")],
            ["returned a FitRecord, expected a DeviceRecord", "from the hook for a fit"],
        ),
    },
    "rule": {
        "forgetting to return": (
            [("        return [\n            Zone", "        [\n            Zone")],
            ["gave None, expected zones"],
        ),
        "the worst verdict first": (
            [
                ("Verdict.PASS, guard", "Verdict.INCONCLUSIVE, guard"),
                ("Verdict.INCONCLUSIVE, -guard", "Verdict.PASS, -guard"),
            ],
            ["'pass' farther out than 'inconclusive', which is worse"],
        ),
        "margins that do not fall": (
            [("Verdict.INCONCLUSIVE, -guard", "Verdict.INCONCLUSIVE, guard")],
            ["zones whose margins do not fall"],
        ),
        "a zone of what fails": (
            [("Verdict.INCONCLUSIVE, -guard", "Verdict.FAIL, -guard")],
            ["the verdict <Verdict.FAIL: 'fail'> of a zone"],
        ),
        "words in German alone": (
            [('            "en": f', '            "fr": f')],
            ["expected {'en': ...}"],
        ),
        "a pass outside the limits": (
            [("Verdict.PASS, guard, width", "Verdict.PASS, -guard / 2, width")],
            ["passes", "passes_outside=True"],
        ),
        "a distance for all units": (
            [("self.settings.share * expanded(estimate),", "0.01 * self.settings.share,")],
            ["in mN·m"],
        ),
    },
    "outlier-rule": {
        "forgetting to return": (
            [("        return [\n            Rejection", "        [\n            Rejection")],
            ["it gave None, expected a list of Rejection"],
        ),
        "indices for rejections": (
            [
                (", float(values[index]), NAME, float(distance[index]), limit)", ")"),
                ("            Rejection(int(index)", "            int(index"),
            ],
            ["it gave [24], expected a list of Rejection"],
        ),
        "a crash": (
            [("np.median(values))", "np.medain(values))")],
            ["AttributeError", "'medain'", "correct", "spring.py:"],
        ),
        "a setting without a type": (
            [("limit: Annotated[float, Field(gt=0, strict=False)] = 3.5", "limit = 3.5")],
            ["A non-annotated attribute was detected: `limit = 3.5`", "write the type"],
        ),
        "no __call__": (
            [("def __call__(", "def call(")],
            ["Spring cannot be called: it needs a method `__call__`", "correct what Spring"],
        ),
    },
    "compensation": {
        "forgetting to return": (
            [("    return Compensation(", "    Compensation(")],
            ["gave None, expected a Compensation", "give one CompensatedPoint for each point"],
        ),
        "a crash": (
            [("raw.value - rig.value", "raw.valeu - rig.value")],
            ["AttributeError", "'valeu'", "correct", "spring.py:"],
        ),
        "a factory that forgets to return": (
            [("    return compensate\n", "    compensate\n")],
            ["the factory of the compensation 'spring' gave None"],
        ),
        "a method that takes nothing": (
            [("def compensate(sweep: Sweep)", "def compensate()")],
            ["compensate takes (), and ", "is called with sweep"],
        ),
    },
    "importer": {
        "forgetting to return": (
            [("        return {wanted: Column(np", "        {wanted: Column(np")],
            ["`read` gave None, expected a Column for each name", "is there a `return`?"],
        ),
        "arrays for columns": (
            [("Column(np.array(values))", "np.array(values)")],
            ["expected a Column for each name that is wanted"],
        ),
        "no read": (
            [("    def read(", "    def raed(")],
            ["Spring has no method `read`"],
        ),
        "letting an OSError out": (
            [("    except OSError as error:", "    except KeyError as error:")],
            ["missing.dat gives FileNotFoundError, which is not a DataError", "catch OSError"],
        ),
        "the class for the object": (
            [("    return Spring()\n", "    return Spring\n")],
            ["Spring.read takes (self, path", "is called with path, columns, group"],
        ),
    },
    "report": {
        "a text for bytes": (
            [('.getvalue().encode("utf-8")', ".getvalue()")],
            ["gave a str, expected bytes", "encode('utf-8')"],
        ),
        "forgetting to return": (
            [("    return text.getvalue()", "    text.getvalue()")],
            ["gave a NoneType, expected bytes"],
        ),
        "a suffix without its dot": (
            [('suffix=".csv"', 'suffix="csv"')],
            ["the suffix is 'csv'"],
        ),
        "a crash": (
            [("each.estimate", "each.estimaet")],
            ["AttributeError", "'estimaet'", "correct", "spring.py:"],
        ),
        "a date of today": (
            [
                ("import csv\n", "import csv\nimport time\n"),
                ("rows.writerow(HEADER)", "rows.writerow([*HEADER, time.monotonic_ns()])"),
            ],
            ["it writes different bytes each time", "write no date of today"],
        ),
    },
}


def write_plugin(folder, word, edits):
    """Write the plugin with its mistake into a folder of plugins; return the folder."""
    text = new_plugin(word, "spring", load_registry()).module()
    for old, new in edits:
        assert old in text, f"no longer in what `rigrunner new` makes: {old}"
        text = text.replace(old, new)
    plugins = folder / "plugins"
    plugins.mkdir()
    (plugins / "spring.py").write_text(text, encoding="utf-8")
    return plugins


def failures(folder, word, edits):
    """Return the report of check-plugin on each failed check."""
    plugins = write_plugin(folder, word, edits)
    called = call("check-plugin", "spring", "--drop-in", plugins)
    assert (called.code, called.err) == (1, "")
    sections = re.split(r"^(?=FAIL|pass|n/a|$)", called.out, flags=re.MULTILINE)
    return [" ".join(section.split()) for section in sections if section.startswith("FAIL")]


@pytest.mark.parametrize("mistake", DEVICE)
def test_one_mistake_in_a_device_is_one_failure(mistake, tmp_path):
    edits, words = DEVICE[mistake]
    (failure,) = failures(tmp_path, "device", edits)
    assert [word for word in words if word not in failure] == [], failure


LONG = {("rule", "words in German alone"), ("rule", "a distance for all units")}
"""Checks of a rule take longest; the case of a pass outside the limits always runs."""
CASES = [
    pytest.param(*case, id=" ".join(case), marks=[pytest.mark.thorough] * (case in LONG))
    for case in ((word, mistake) for word, mistakes in OTHERS.items() for mistake in mistakes)
]


@pytest.mark.parametrize(("word", "mistake"), CASES)
def test_one_mistake_in_another_plugin_is_one_failure(word, mistake, tmp_path):
    edits, words = OTHERS[word][mistake]
    (failure,) = failures(tmp_path, word, edits)
    assert [word for word in words if word not in failure] == [], failure


def test_hanging_call_is_one_failure_with_its_line(tmp_path, monkeypatch):
    monkeypatch.setattr(import_module("rigrunner_testing.examination"), "RELEASE_S", 0.3)
    waits = [
        ("from rigrunner.api import", "import time\n\nfrom rigrunner.api import"),
        (GET, "        while True:\n            time.sleep(0.01)\n"),
    ]
    registry = with_drop_ins(load_registry(), write_plugin(tmp_path, "device", waits))
    hanging = subject("device", "spring", registry=registry)
    hanging.made_devices.clear()
    chosen = [check for check in checks("device") if check.name in HANGING]
    findings = list(examine(hanging, chosen, longest_s=0.3))
    (failure,) = [finding for finding in findings if finding.state is State.FAIL]
    assert "did not come back within 0.3 s: it waits in" in failure.text
    assert re.search(r"spring.py:3[12]", failure.fix)
    after = findings[findings.index(failure) + 1 :]
    assert {finding.state for finding in after} == {State.NOT_JUDGED}


HANGING = {
    "can_be_made",
    "connects_and_says_who_it_is",
    "quantities_declared",
    "readings_are_true",
    "drives_go_where_they_are_set",
    "safe_is_confirmed",
}


@pytest.mark.parametrize(
    ("place", "words"),
    [
        ("spring_nowhere", ["No module named 'spring_nowhere'", "names 'spring_nowhere'"]),
        ("json", ["it does not say for which plugin API it is made"]),
    ],
)
def test_wrong_module_of_an_entry_point_is_reported(place, words):
    registry = load_registry([EntryPoint("spring", place, "rigrunner")])
    disabled = registry.disabled_with("spring")
    assert disabled is not None
    assert [word for word in words if word not in f"{disabled.reason} {disabled.fix}"] == []


def test_check_not_judged_names_the_failure(tmp_path):
    plugins = write_plugin(tmp_path, "device", DEVICE["a str from get"][0])
    called = call("check-plugin", "spring", "--drop-in", plugins, "--json")
    (document,) = json.loads(called.out)
    states = {
        finding["check"]: (finding["state"], finding["found"]) for finding in document["findings"]
    }
    assert states["limits_hold"] == ("not judged", "it needs what 'readings_are_true' demands")
    assert {check.name for check in checks("device")} == set(states)


def test_two_independent_mistakes_are_both_reported(tmp_path):
    edits = [*DEVICE["a str from get"][0], ("Spring, by lines of text", "")]
    names = [failure.split()[1] for failure in failures(tmp_path, "device", edits)]
    assert names == ["help_line", "readings_are_true"]


def test_left_safe_always_runs_last():
    """Not of a simulator: nothing is energised, and the failure would be the same."""
    (left_safe,) = [check for check in checks("device") if check.always]
    assert left_safe.name == "left_safe"
    assert left_safe is checks("device")[-1]


@pytest.mark.parametrize("kind", ["device", "fit", "report_format", "event_sink", "compensation"])
def test_every_check_follows_those_it_needs(kind):
    seen = set()
    for check in checks(kind):
        assert seen.issuperset(check.needs), check
        seen.add(check.name)
