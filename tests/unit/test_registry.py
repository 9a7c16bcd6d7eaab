import json
import re
import sys
from importlib import import_module
from importlib.metadata import EntryPoint
from pathlib import Path

import pytest
from pydantic import ValidationError

from helpers_devices import FakeTester
from rigrunner import __version__
from rigrunner.api.devices import ChannelInfo, DeviceContext, DriveInfo
from rigrunner.api.errors import PluginError
from rigrunner.api.hooks import DeviceRecord, FitRecord, Imported, ReportFormatRecord
from rigrunner.api.settings import Force, Frequency, Length, Settings
from rigrunner.clock import SimulatedClock
from rigrunner.registry import Plugin, Provider, Registry, load_registry, loading, with_drop_ins
from rigrunner.registry.declared import declaration_problems

GOOD = """
from rigrunner.api.hooks import FitRecord, hookimpl
from rigrunner.api.settings import Frequency, Settings

api_version = 1

class LineSettings(Settings):
    cutoff: Frequency = 5.0

@hookimpl
def rigrunner_fits():
    return [FitRecord(name="line", help="A line.", settings=LineSettings, factory=lambda s: s)]
"""

HEAD = "from rigrunner.api.hooks import hookimpl\napi_version = 1\n"


@pytest.fixture
def entry(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(str(tmp_path))

    def make(name, source):
        (tmp_path / f"{name}.py").write_text(source)
        return EntryPoint(name, name, "rigrunner")

    return make


def test_plugin_is_found_by_kind_and_name(entry):
    registry = load_registry([entry("good_one", GOOD)])
    assert registry.names("fit") == ["line"]
    assert registry.find("fit", "line").provider.name == "good_one"
    assert registry.settings_of("fit", "line").__name__ == "LineSettings"


def test_settings_are_validated_before_the_factory_is_called(entry):
    registry = load_registry([entry("good_two", GOOD)])
    assert registry.make("fit", "line", {"cutoff": "2 kHz"}).cutoff == 2000.0
    with pytest.raises(PluginError, match=r"fit 'line': cutoff.*torque.*frequency"):
        registry.make("fit", "line", {"cutoff": "2 N·m"})


def test_unknown_name_gets_a_suggestion(entry):
    registry = load_registry([entry("good_three", GOOD)])
    with pytest.raises(PluginError, match="did you mean 'line'"):
        registry.find("fit", "lime")


def test_duplicate_name_is_refused_naming_both_providers(entry):
    registry = load_registry([entry("lab_a", GOOD), entry("lab_b", GOOD)])
    with pytest.raises(PluginError, match="provided twice, by lab_a and lab_b"):
        registry.find("fit", "line")


@pytest.mark.parametrize(
    ("source", "reason"),
    [
        ("import no_such_module_at_all", "ModuleNotFoundError"),
        ("raise SystemError('boom')", "boom"),
        ("raise SystemExit('bye')", "SystemExit: bye"),
        ("import asyncio\nraise asyncio.CancelledError", "CancelledError"),
        (
            f"{HEAD}@hookimpl\ndef rigrunner_fit(): return []",
            "is not the name of a hook (call it rigrunner_fits)",
        ),
        (f"{HEAD}@hookimpl\ndef rigrunner_fits(): return [1]", "not a plugin record"),
        (f"{HEAD}@hookimpl\ndef rigrunner_fits(): pass", "rigrunner_fits returned None, expected"),
        (f"{HEAD}@hookimpl\ndef rigrunner_fits(): return 1", "TypeError: 'int' object is not iter"),
        (f"{HEAD}@hookimpl\ndef rigrunner_fits(x): return []", "{'x'}"),
        (HEAD, "it brings nothing: no function of it is a hook"),
        (f"{HEAD}def rigrunner_fits(): return []", "rigrunner_fits is not marked as a hook"),
        (f"{HEAD}def rigrunner_fitts(): return []", "rigrunner_fitts is not marked as a hook"),
        (f"{HEAD}\n@hookimpl\ndef rigrunner_fits():\n    return [1 / 0]", ".py:6)"),
        (
            GOOD.replace("def rigrunner_fits", "def rigrunner_devices"),
            "rigrunner_devices returned a FitRecord, expected a DeviceRecord",
        ),
        (GOOD.replace("return [", "return ").replace(")]", ")"), "expected a list of FitRecord"),
        (GOOD.replace('"line"', "None"), "the record None of rigrunner_fits: a name has small"),
        (GOOD.replace('"line"', '"my line"'), "'my line' of rigrunner_fits: a name has small"),
        (GOOD.replace("lambda s: s", "None"), "'line' of rigrunner_fits: its factory cannot be"),
        (GOOD.replace("settings=LineSettings", "settings=dict"), "no subclass of Settings"),
        *(
            (GOOD.replace('help="', f'revision={version}, help="'), "its revision is")
            for version in ("0", "-1", "1.0", "True", "None")
        ),
    ],
)
def test_broken_plugin_is_disabled_and_others_are_loaded(entry, source, reason):
    name = "broken_" + str(abs(hash(source)))
    registry = load_registry([entry(name, source), entry("good_" + name, GOOD)])
    assert registry.names("fit") == ["line"]
    (disabled,) = registry.disabled
    assert disabled.provider.name == name
    assert reason in disabled.reason
    assert "pluggy" not in disabled.reason


class Pressed(FakeTester):
    """A device with given declarations."""

    def __init__(self, channels=(), drives=()):
        super().__init__(channels=channels, drives=drives)


def force(*limits, **changes):
    return Pressed(drives=[DriveInfo("force", "N", "Force", *(limits or (0.0, 1.0)), **changes)])


@pytest.mark.parametrize(
    ("device", "problem"),
    [
        (None, "its factory gave a NoneType, which has no channels, drives"),
        (Pressed(None), "got None, expected a sequence of ChannelInfo"),
        (Pressed(["force"]), "got 'force', expected a sequence of ChannelInfo"),
        (Pressed([ChannelInfo("torque", "mN·m", "")]), "'torque': is in 'mN·m', expected the"),
        (Pressed([ChannelInfo("oil", "°C", "")]), "expected the coherent SI unit, K"),
        (
            Pressed([ChannelInfo("a", "N", ""), ChannelInfo("a", "K", "")]),
            "the name is given twice",
        ),
        (Pressed([ChannelInfo("a.b", "N", "")]), "'a.b': a name has letters, digits and '_'"),
        (force(1.0, 0.0), "its limits are 1.0 and 0.0, expected two finite numbers"),
        (force(0.0, float("inf")), "its limits are 0.0 and inf"),  # any value is within 1 % of that
        (force(float("nan"), float("nan")), "its limits are nan and nan"),
        (force("0", "1"), "its limits are 0 and 1"),
        (force(tolerance=float("inf")), "its tolerance is inf"),
        (force(tolerance=-1.0), "its tolerance is -1.0"),
        (force(rate_per_s=-1.0), "its rate is -1.0"),
        (force(settle_s=float("nan")), "it settles in nan s"),
        (force(safe_value=float("nan")), "its safe value is nan"),
        (force(sets_cycle_frequency=True), "it sets the cycle frequency, in N"),
    ],
)
def test_invalid_declaration_of_device_is_refused(device, problem):
    record = DeviceRecord(name="press", help="", factory=lambda *_: device)
    registry = Registry([Plugin("device", record, Provider("lab", "1"))])
    with pytest.raises(PluginError, match=r"^device 'press': ") as caught:
        registry.make_device("press", {}, DeviceContext("press", SimulatedClock(), Path()))
    assert problem in caught.value.message
    assert "rigrunner check-plugin press" in caught.value.hint


@pytest.mark.skipif(sys.version_info < (3, 12), reason="a Protocol counts __getattr__ there")
def test_members_that_getattr_gives_are_named():
    class Delegating:
        def __getattr__(self, name):
            return getattr(FakeTester(), name)

    (problem,) = declaration_problems(Delegating())
    assert problem == (
        "its factory gave a Delegating,"
        " of which __getattr__ gives members that its class must define"
    )


def test_channel_in_unknown_unit_is_accepted():
    device = Pressed([ChannelInfo("light", "lx", "Light")])
    assert list(declaration_problems(device)) == []


def failing(error):
    def factory(_):
        raise error

    record = FitRecord(name="line", help="", factory=factory)
    return Registry([Plugin("fit", record, Provider("lab", "1"))])


def test_unexpected_factory_error_has_note_with_plugin():
    with pytest.raises(ValueError, match="oops") as caught:
        failing(ValueError("oops")).make("fit", "line", {})
    assert caught.value.__notes__ == ["in the fit 'line' of lab 1"]


def test_factory_cannot_end_the_program():
    with pytest.raises(RuntimeError, match=r"the fit 'line' of lab 1 raised SystemExit\(0\)"):
        failing(SystemExit(0)).make("fit", "line", {})


@pytest.mark.parametrize("content", ["a text", None, 5])
def test_report_format_must_return_bytes(content):
    record = ReportFormatRecord(
        name="mine", help="", suffix=".x", factory=lambda _: lambda _: content
    )
    registry = Registry([Plugin("report_format", record, Provider("lab", "1"))])
    with pytest.raises(PluginError, match=r"the report format 'mine' gave a .*, expected bytes"):
        registry.make("report_format", "mine", {})(None)


def test_unreadable_drop_in_is_disabled_and_others_are_loaded(folder):
    (folder / "no_file.py").mkdir()
    (folder / "gone.py").symlink_to(folder / "nowhere")
    (folder / "good.py").write_text(GOOD)
    registry = with_drop_ins(load_registry([]), folder)
    assert registry.names("fit") == ["line"]
    assert sorted(Path(plugin.provider.name).name for plugin in registry.disabled) == [
        "gone.py",
        "no_file.py",
    ]


def declaring(line):
    return GOOD.replace("api_version = 1", line)


@pytest.fixture
def three_api_versions(monkeypatch):
    """This Rigrunner has the APIs 2 to 4."""
    monkeypatch.setattr(loading, "OLDEST_API_VERSION", 2)
    monkeypatch.setattr(loading, "API_VERSION", 4)


@pytest.mark.usefixtures("three_api_versions")
@pytest.mark.parametrize("made_for", [2, 3, 4])
def test_plugin_for_supported_api_is_loaded(entry, made_for):
    registry = load_registry([entry(f"kept_{made_for}", declaring(f"api_version = {made_for}"))])
    assert registry.names("fit") == ["line"]
    assert registry.disabled == ()


TOO_NEW = (
    "it is made for plugin API 5, and Rigrunner {} has 2 to 4"
    " (update Rigrunner, or install a version of it for API 4)"
)
TOO_OLD = (
    "it is made for plugin API 1, and Rigrunner {} has 2 to 4"
    " (install a newer version of it, for API 2 to 4, or an older Rigrunner)"
)
NO_VERSION = (
    "it does not say for which plugin API it is made (its module needs a line 'api_version = 4')"
)


@pytest.mark.usefixtures("three_api_versions")
@pytest.mark.parametrize(
    ("line", "reason"),
    [
        ("api_version = 5", TOO_NEW),
        ("api_version = 1", TOO_OLD),
        ("", NO_VERSION),
        ("api_version = '4'", NO_VERSION),
        ("api_version = True", NO_VERSION),
    ],
)
def test_plugin_for_unsupported_api_is_disabled_with_advice(entry, line, reason):
    registry = load_registry([entry("aged_" + str(abs(hash(line))), declaring(line))])
    assert {plugin.kind for plugin in registry.plugins} == {"step"}  # of the language itself
    assert [plugin.reason for plugin in registry.disabled] == [reason.format(__version__)]


@pytest.mark.parametrize("line", ["api_version = 99", "api_version: int = 99  # of next year"])
def test_api_version_is_checked_before_import_errors(entry, folder, line):
    source = f"from rigrunner.api.hooks import OfNextYear\n{line}\n"
    (folder / "drop_in.py").write_text(source)
    installed = load_registry([entry("newer_" + str(len(line)), source)])
    for disabled in with_drop_ins(installed, folder).disabled:
        assert disabled.reason.startswith("it is made for plugin API 99"), disabled


def test_unknown_name_error_lists_disabled_plugins(entry):
    registry = load_registry([entry("from_the_future", declaring("api_version = 99"))])
    with pytest.raises(PluginError, match=r"no fit 'line'.*disabled: from_the_future: .* API 99"):
        registry.find("fit", "line")


def test_settings_refuse_bare_number():
    class Drive(Settings):
        speed: Frequency

    with pytest.raises(ValueError, match="not a number with a unit"):
        Drive.model_validate({"speed": 5})


@pytest.fixture
def folder(tmp_path):
    drop_ins = tmp_path / "plugins"
    drop_ins.mkdir()
    return drop_ins


def test_drop_ins_are_loaded_by_path_and_leave_the_import_path_alone(folder):
    (folder / "lab_fit.py").write_text(GOOD)
    (folder / "_helper.py").write_text("raise SystemError('not a plugin')")
    before = list(sys.path)
    registry = with_drop_ins(load_registry([]), folder)
    assert sys.path == before
    provider = registry.find("fit", "line").provider
    assert provider.name == str(folder / "lab_fit.py")
    assert provider.version.startswith("sha256:")
    assert registry.make("fit", "line", {}).cutoff == 5.0


def test_drop_in_cannot_shadow_installed_plugin(entry, folder):
    (folder / "mine.py").write_text(GOOD)
    registry = with_drop_ins(load_registry([entry("installed_one", GOOD)]), folder)
    with pytest.raises(PluginError, match=r"by installed_one and .*mine\.py"):
        registry.find("fit", "line")


def test_broken_drop_in_is_disabled_and_others_are_loaded(folder):
    (folder / "broken.py").write_text("def f(:")
    (folder / "good.py").write_text(GOOD)
    registry = with_drop_ins(load_registry([]), folder)
    assert registry.names("fit") == ["line"]
    (disabled,) = registry.disabled
    assert "SyntaxError" in disabled.reason


def test_missing_drop_in_folder_is_named(tmp_path):
    with pytest.raises(PluginError, match=r"there is no plugin folder .*nowhere"):
        with_drop_ins(load_registry([]), tmp_path / "nowhere")


class InRole(FakeTester):
    """A device that knows its role."""

    def __init__(self, role, **changes):
        super().__init__(**changes)
        self.role = role


class Tap:
    """Records where it is placed: at the wire of a role, or at its calls."""

    def __init__(self):
        self.places = []

    def with_wire(self, context):
        self.places.append(("wire", context.role))
        return context

    def with_call_mark(self, device, context):  # noqa: ARG002  (a Tap's)
        return device

    def at_calls(self, device, context):
        self.places.append(("calls", context.role))
        return device


@pytest.mark.parametrize(
    ("wired", "expected"),
    [
        ({}, [("calls", "tester")]),
        ({"whole"}, [("wire", "tester"), ("calls", "tester/part")]),
        ({"whole", "part"}, [("wire", "tester"), ("wire", "tester/part")]),
        ({"part"}, [("calls", "tester")]),
    ],
    ids=["none", "the whole", "both", "the part"],
)
def test_tap_is_placed_once_between_device_and_instrument(wired, expected):
    """A device made of parts is tapped at its parts if it is wired itself, else as a whole."""
    records = {
        "part": lambda _, context: InRole(context.role),
        "whole": lambda _, context: context.make("part", {}, part="part"),
    }
    registry = Registry(
        Plugin(
            "device",
            DeviceRecord(name=name, help="", factory=factory, wired=name in wired),
            Provider("tests", "1"),
        )
        for name, factory in records.items()
    )
    tap = Tap()
    context = DeviceContext("tester", SimulatedClock(), Path())
    assert registry.make_device("whole", {}, context, tap).role == "tester/part"
    assert tap.places == expected


BY_PLACE = """
from rigrunner.api.hooks import FitRecord, hookimpl

api_version = 1

@hookimpl
def rigrunner_fits():
    return [
        FitRecord(name="line", help="A line.", settings="PLACE", factory=lambda s: s),
        FitRecord(name="plain", help="Nothing to set.", factory=lambda s: s),
    ]
"""


def test_settings_given_by_place_are_imported_on_use(entry, tmp_path):
    (tmp_path / "line_settings_of_a_lab.py").write_text(
        "from rigrunner.api.settings import Frequency, Settings\n"
        "class LineSettings(Settings):\n    cutoff: Frequency\n"
    )
    source = BY_PLACE.replace("PLACE", "line_settings_of_a_lab:LineSettings")
    registry = load_registry([entry("by_place", source)])
    assert "line_settings_of_a_lab" not in sys.modules
    assert registry.make("fit", "line", {"cutoff": "2 kHz"}).cutoff == 2000.0
    with pytest.raises(PluginError, match="fit 'line': cutoff"):
        registry.make("fit", "line", {"cutoff": "2 N"})


def test_factory_given_by_place_is_imported_on_use(entry, tmp_path):
    (tmp_path / "line_fit_of_a_lab.py").write_text("def line(settings):\n    return settings, 1\n")
    source = GOOD.replace("factory=lambda s: s", "factory=Imported('line_fit_of_a_lab:line')")
    source = source.replace("import FitRecord", "import FitRecord, Imported")
    registry = load_registry([entry("imports_its_factory", source)])
    assert "line_fit_of_a_lab" not in sys.modules
    settings, one = registry.make("fit", "line", {"cutoff": "2 kHz"})
    assert (settings.cutoff, one) == (2000.0, 1)


def test_imported_product_is_returned_uncalled():
    record = ReportFormatRecord(
        name="x", help="X.", suffix=".x", factory=Imported("json:dumps", called=False)
    )
    assert record.factory(None) is json.dumps


@pytest.mark.parametrize("place", ["no_such_module_at_all:Fit", "rigrunner.api:NoSuch", "re", ""])
def test_place_without_factory_is_named(place):
    plugin = Plugin(
        "fit", FitRecord(name="x", help="X.", factory=Imported(place)), Provider("x", "")
    )
    with pytest.raises(PluginError, match=f"'{place}' cannot be loaded: "):
        Registry([plugin]).make("fit", "x", {})


def test_every_imported_function_of_a_shipped_record_exists():
    places = {
        value.place
        for plugin in load_registry().plugins
        for value in vars(plugin.record).values()
        if isinstance(value, Imported)
    }
    assert places
    for place in places:
        module, _, name = place.partition(":")
        assert callable(getattr(import_module(module), name)), place


@pytest.mark.parametrize(
    ("place", "reason"),
    [
        ("no_such_module_at_all:Settings", "No module named 'no_such_module_at_all'"),
        ("rigrunner.api.settings:NoSuch", "NoSuch"),
        ("rigrunner.api.settings", "cannot be loaded"),
        ("", "cannot be loaded"),
        ("pathlib:Path", "'pathlib:Path' is not a model of settings"),
        ("rigrunner.api.settings:Torque", "is not a model of settings"),
    ],
)
def test_settings_missing_at_their_place_disable_only_their_plugin(entry, place, reason):
    name = "misplaced_" + str(abs(hash(place)))
    registry = load_registry([entry(name, BY_PLACE.replace("PLACE", place))])
    assert registry.names("fit") == ["line", "plain"]
    with pytest.raises(PluginError, match=re.escape(reason)):
        registry.settings_of("fit", "line")
    checked = registry.with_all_settings()
    assert checked.names("fit") == ["plain"]
    assert reason in str(checked.disabled[0])
    assert str(checked.disabled[0]).startswith(f"{name}: fit 'line': ")


def test_settings_of_shipped_plugins_are_at_their_places():
    registry = load_registry()
    checked = registry.with_all_settings()
    assert [plugin.record.name for plugin in checked.plugins] == [
        plugin.record.name for plugin in registry.plugins
    ]
    assert checked.disabled == ()


def test_folders_and_broken_links_as_drop_ins_are_disabled(folder):
    (folder / "good.py").write_text(GOOD)
    (folder / "a_folder.py").mkdir()
    (folder / "nowhere.py").symlink_to(folder / "gone.py")
    registry = with_drop_ins(load_registry([]), folder)
    assert {Path(plugin.provider.name).name for plugin in registry.disabled} >= {
        "a_folder.py",
        "nowhere.py",
    }
    assert registry.names("fit") == ["line"]


class Bore(Settings):
    bore: Length = 0.01


class OtherBore(Settings):
    bore: Force = 1.0


def fit_of_a_rig(name, rig):
    record = FitRecord(name=name, help="A fit.", factory=lambda _: None, rig=rig)
    return Plugin("fit", record, Provider(f"the_{name}", "1"))


def test_rig_has_keys_declared_by_plugins():
    assert set(Registry([]).rig_model().model_fields) == set()
    model = Registry([fit_of_a_rig("one", Bore), fit_of_a_rig("two", Bore)]).rig_model()
    assert model.model_validate({"bore": "3 mm"}).bore == 0.003
    with pytest.raises(ValidationError, match="extra"):
        model.model_validate({"mandrel": "M-1"})


def test_conflicting_rig_key_is_refused_naming_both_plugins():
    registry = Registry([fit_of_a_rig("one", Bore), fit_of_a_rig("two", OtherBore)])
    plugins = "by the fit 'one' of the_one 1 and the fit 'two' of the_two 1"
    with pytest.raises(PluginError, match=f"'bore' of a rig is declared twice, {plugins}"):
        registry.rig_model()


def test_plugin_without_rig_keys_has_none():
    assert load_registry().rig_of("device", "visa") is None
