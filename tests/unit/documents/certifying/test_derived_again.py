"""A run must give the numbers today that it gave when it was sealed, or no certificate is made."""

import copy
import json
from dataclasses import replace

import pytest

from rigrunner.analysis.document import document
from rigrunner.api.errors import DataError
from rigrunner.documents.certifying.derived_again import refuse_other_numbers
from rigrunner.registry import load_registry
from rigrunner.run.stored import analyse_run
from rigrunner.runfile import read


@pytest.fixture(scope="module")
def analysed(quick):
    return read(quick.loaded), analyse_run(quick.loaded, load_registry())


def sealed_with(stored, change):
    content = json.loads(json.dumps(copy.deepcopy(stored.result_document)))
    change(content)
    return replace(stored, result_document=content)


def test_the_same_numbers_pass(analysed):
    refuse_other_numbers(*analysed)


def test_a_sum_that_another_machine_rounds_otherwise_passes(analysed):
    def rounded(content):
        content["headline"]["compensated"]["value"] *= 1 + 1e-9

    stored, result = analysed
    refuse_other_numbers(sealed_with(stored, rounded), result)


@pytest.mark.parametrize("number", ["value", "standard_uncertainty", "expanded_uncertainty_95"])
def test_another_headline_is_refused_with_both_numbers(analysed, number):
    def changed(content):
        content["headline"]["compensated"][number] += 0.0015

    stored, result = analysed
    shown = f"{document(result)['headline']['compensated']['value']:.6g}"
    with pytest.raises(DataError, match="the mean was .* ± .* N·m, is " + shown) as caught:
        refuse_other_numbers(sealed_with(stored, changed), result)
    assert "changed" in caught.value.hint


def test_another_set_point_is_refused(analysed):
    def changed(content):
        points = content["compensations"]["template_inverse"]["points"]
        points[2]["torque"]["value"] += 0.001

    stored, result = analysed
    with pytest.raises(DataError, match="20 Hz was"):
        refuse_other_numbers(sealed_with(stored, changed), result)


def test_each_visit_of_a_frequency_is_compared(analysed, monkeypatch):
    stored, result = analysed

    def at_one_frequency(content):
        for point in content["compensations"]["template_inverse"]["points"]:
            point["set_frequency"]["value"] = 5.0

    def changed(content):
        at_one_frequency(content)
        content["compensations"]["template_inverse"]["points"][0]["torque"]["value"] += 0.001

    today = sealed_with(stored, at_one_frequency)
    where = "rigrunner.documents.certifying.derived_again.document"
    monkeypatch.setattr(where, lambda _: today.result_document)
    refuse_other_numbers(today, result)
    with pytest.raises(DataError, match="at 5 Hz was"):
        refuse_other_numbers(sealed_with(stored, changed), result)


def test_an_uncertainty_that_was_not_known_is_another_number(analysed):
    def changed(content):
        content["headline"]["compensated"]["standard_uncertainty"] = None

    stored, result = analysed
    with pytest.raises(DataError, match="different numbers"):
        refuse_other_numbers(sealed_with(stored, changed), result)


def test_a_run_sealed_without_result_has_nothing_to_compare(analysed):
    stored, result = analysed
    refuse_other_numbers(replace(stored, result_document=None), result)


def test_another_revision_of_a_method_is_named(analysed):
    def changed(content):
        content["headline"]["compensated"]["value"] += 0.0015
        del content["revisions"]["analysis"]

    stored, result = analysed
    newer = replace(result, revisions={**result.revisions, "analysis": 7})
    with pytest.raises(DataError) as caught:
        refuse_other_numbers(sealed_with(stored, changed), newer)
    hint = "analysis has revision 7, the run was computed by revision 1; certify with the versions"
    assert caught.value.hint.startswith(hint)


def test_a_result_that_no_installed_package_reads_is_not_certified(analysed, monkeypatch):
    monkeypatch.setattr("rigrunner.run.set_points._readers", tuple)
    with pytest.raises(DataError, match="reads points, no_load_points, compens"):
        refuse_other_numbers(*analysed)
