"""Which checks of the conformance kit do not apply to which shipped plugin.

A check that silently no longer applies would prove nothing.
"""

from __future__ import annotations

from rigrunner.registry import load_registry
from rigrunner_testing import checks, conform

REGISTRY = load_registry()
SCANS = {
    "farther_within_is_no_worse",
    "lower_and_upper_limit_are_alike",
    "the_unit_does_not_matter",
    "passes_nothing_outside_the_limits",
    "less_certain_is_no_better",
    "stated_risks_are_those_of_its_verdicts",
}
"""Checks of a decision rule that apply it to about ten thousand values."""
_UNITS = {"wrong_unit_refused"}  # it has no settings with units
_SETTINGS = {"wrong_type_refused", *_UNITS}  # it has no typed settings
_STREAM = {
    "safe_while_streaming",
    "streams_are_gapless",
    "blocks_are_whole",
    "streams_take_their_time",
    "stops_in_time",
    "streams_may_be_left",
    "continues_after_streams",
}
_DRIVES = {
    "drives_go_where_they_are_set",
    "drives_are_waited_for_by_asking",
    "limits_hold",
    "safe_is_confirmed",
    "safe_while_streaming",
    "safe_after_a_failed_call",
    "safe_though_one_drive_fails",
    "safe_after_closing",
    "pauses_and_resumes",
    "left_safe",
}
_NO_SIMULATOR = {"other_seed_other_samples", "only_a_simulator_knows_the_truth"}
_INSTRUMENT = {*_NO_SIMULATOR, "non_blocking_is_true"}  # it may wait
_READ_BY_VALUE = {*_STREAM, "pauses_and_resumes", *_INSTRUMENT}
_AT_ONCE = {"drives_are_waited_for_by_asking"}  # its drives have arrived when `set` returns
_NO_WIRE = {
    "exchanges_go_over_the_wire",
    "only_device_errors_leave_it",
    "recovers_after_a_failure",
}
_OF_PARTS = {  # the parts have them
    "exchanges_go_over_the_wire",
    "other_seed_other_samples",
    "recovers_after_a_failure",
}
_REPLAY = {
    "drives_are_waited_for_by_asking",
    "pauses_and_resumes",
    "other_seed_other_samples",
    "only_a_simulator_knows_the_truth",
    "continues_after_streams",
    *_NO_WIRE,
    "gives_up_in_time",
}
_NOBODY = {"gives_up_in_time"}  # the record names no settings of an unreachable device
_FILES = {"examples_are_read", "missing_columns_are_named", "cut_files_refused"}
_TRUTH = {"truth_is_within_its_interval", "truth_is_within_it_on_another_rig"}
_FIT_EXAMPLES = {"published_examples_hold"}
_RULE_EXAMPLES = {"published_rejections_hold"}
_AT_ONCE_DONE = {"stops_when_asked", "is_resumed_or_refuses"}  # it takes no time to be stopped in

_MEASURAND = {"limits_can_say_which_result"}
_PARTNERS = {"refuses_a_partner_run_that_lacks_a_channel"}  # none of the examples has one
_OF_TORQUE = {
    *_UNITS,
    *_PARTNERS,
    "says_what_it_requires",
    "refuses_a_run_that_lacks_a_channel",
    "a_worse_instrument_is_no_surer",
    "covers_the_truth",
    "live_shows_what_it_finds",
}
"""Checks of analyses that are tried on runs of their own."""
NOT_APPLICABLE: dict[tuple[str, str], set[str]] = {
    ("analysis", "curve"): {*_UNITS, *_PARTNERS, *_MEASURAND, "live_shows_what_it_finds"},
    ("analysis", "equation"): {*_UNITS, *_PARTNERS, *_MEASURAND, "live_shows_what_it_finds"},
    ("analysis", "readings"): {*_PARTNERS, *_MEASURAND},
    ("analysis", "breakaway"): _OF_TORQUE - _UNITS,
    ("analysis", "swing_torque"): _OF_TORQUE,
    ("certificate_format", "html"): _SETTINGS,
    ("certificate_format", "pdf"): {*_SETTINGS, "names_are_escaped"},
    ("report_format", "html"): _SETTINGS,
    ("study_format", "html"): _SETTINGS,
    ("kind", "compensation"): _SETTINGS,
    ("lab", "bearings"): _SETTINGS,
    ("compensation", "breakaway_peak"): {
        "truth_is_within_it_on_another_rig",
        "common_offset_falls_out",
        "without_no_load_run_it_refuses",
    },
    ("compensation", "energy"): _TRUTH,
    ("compensation", "paper_peak"): {*_TRUTH, *_UNITS},
    ("compensation", "peak_same_frequency"): _TRUTH,
    ("device", "composite"): {*_UNITS, *_OF_PARTS, *_NOBODY},
    ("device", "fault"): {*_UNITS, *_OF_PARTS, *_AT_ONCE},
    ("device", "modbus"): _READ_BY_VALUE,
    ("device", "opcua"): {*_READ_BY_VALUE, "same_seed_same_samples"},
    ("device", "pymeasure"): _READ_BY_VALUE,
    ("device", "replay"): _REPLAY,
    ("device", "rotation_tester_sim"): {*_AT_ONCE, *_NO_WIRE, "pauses_and_resumes"},
    ("device", "serial_ascii"): {*_DRIVES, *_INSTRUMENT, "continues_after_streams"},
    ("device", "swing_tester_ode"): {*_AT_ONCE, *_NO_WIRE},
    ("device", "swing_tester_sim"): {*_AT_ONCE, *_NO_WIRE},
    ("device", "tabulated"): {
        *_UNITS,
        *_NOBODY,
        *_AT_ONCE,
        *_STREAM,
        *_NO_SIMULATOR,
        *_NO_WIRE,
        "pauses_and_resumes",
    },
    ("device", "visa"): _READ_BY_VALUE,
    ("fit", "aicc"): {*_UNITS, *_FIT_EXAMPLES},
    ("fit", "basis"): _UNITS,
    ("fit", "expression"): _UNITS,
    ("fit", "inertia_physical"): _FIT_EXAMPLES,
    ("fit", "pchip"): {*_SETTINGS, *_FIT_EXAMPLES},
    ("fit", "polynomial"): _UNITS,
    ("importer", "csv"): _UNITS,
    ("importer", "hdf5"): {*_SETTINGS, *_FILES},
    ("importer", "lvm"): {*_UNITS, *_FILES},
    ("importer", "matlab"): {*_SETTINGS, *_FILES},
    ("importer", "tdms"): {*_SETTINGS, *_FILES},
    ("outlier_rule", "chauvenet"): _SETTINGS,
    ("outlier_rule", "generalized_esd"): _UNITS,
    ("outlier_rule", "grubbs"): _UNITS,
    ("outlier_rule", "mad"): {*_UNITS, *_RULE_EXAMPLES},
    ("outlier_rule", "none"): {*_SETTINGS, *_RULE_EXAMPLES, "finds_a_gross_error"},
    ("outlier_rule", "pauta"): {*_SETTINGS, *_RULE_EXAMPLES},
    ("step", "ask"): {*_UNITS, *_AT_ONCE_DONE},
    ("step", "call"): {
        *_UNITS,
        *_AT_ONCE_DONE,
        "is_planned",
        "takes_its_time",
        "leaves_the_rig_safe",
    },
    ("step", "confirm"): {*_UNITS, *_AT_ONCE_DONE},
    ("step", "group"): _UNITS,
    ("step", "measure"): _AT_ONCE_DONE,
    ("step", "note"): {*_UNITS, *_AT_ONCE_DONE},
    ("step", "repeat"): _UNITS,
    ("step", "scan"): _AT_ONCE_DONE,
    ("step", "set"): _AT_ONCE_DONE,
    ("step", "sweep"): _UNITS,
    ("step", "zero"): _AT_ONCE_DONE,
}


NOT_APPLICABLE |= {  # no example has settings that mark invalid readings
    ("device", name): {*NOT_APPLICABLE.get(("device", name), ()), "readings_are_told"}
    for name in REGISTRY.names("device")
}
NOT_APPLICABLE |= {
    ("decision_rule", name): _UNITS
    if REGISTRY.settings_of("decision_rule", name).model_fields
    else _SETTINGS
    for name in REGISTRY.names("decision_rule")
}


def applicable(kind: str, name: str):
    """Return the checks that apply to a plugin."""
    excluded = NOT_APPLICABLE.get((kind, name), set())
    return [check for check in checks(kind) if check.name not in excluded]


def assert_it_conforms(subject, check) -> None:
    """Run the check, which must apply."""
    why_not = conform(subject, check)
    assert not why_not, f"{why_not}: if that is right, it belongs into NOT_APPLICABLE"


def assert_not_applicable(subject) -> None:
    """Run the checks listed as not applicable; each must say why it does not apply."""
    excluded = NOT_APPLICABLE[subject.kind, subject.name]
    for check in checks(subject.kind):
        if check.name in excluded:
            assert conform(subject, check), f"{check} applies"
