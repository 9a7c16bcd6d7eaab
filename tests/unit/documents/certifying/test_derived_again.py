"""No certificate is issued unless the analysis still gives the numbers of the sealed run."""

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


def test_same_numbers_pass(analysed):
    refuse_other_numbers(*analysed)


def test_rounding_difference_passes(analysed):
    def rounded(content):
        content["headline"]["compensated"]["value"] *= 1 + 1e-9

    stored, result = analysed
    refuse_other_numbers(sealed_with(stored, rounded), result)


@pytest.mark.parametrize("number", ["value", "standard_uncertainty", "expanded_uncertainty_95"])
def test_different_headline_is_refused_with_both_numbers(analysed, number):
    def changed(content):
        content["headline"]["compensated"][number] += 0.0015

    stored, result = analysed
    shown = f"{document(result)['headline']['compensated']['value']:.6g}"
    with pytest.raises(DataError, match="the mean was .* ± .* N·m, is " + shown) as caught:
        refuse_other_numbers(sealed_with(stored, changed), result)
    assert "changed" in caught.value.hint


def test_different_value_at_a_set_point_is_refused(analysed):
    def changed(content):
        points = content["compensations"]["template_inverse"]["points"]
        points[2]["torque"]["value"] += 0.001

    stored, result = analysed
    with pytest.raises(DataError, match="20 Hz was"):
        refuse_other_numbers(sealed_with(stored, changed), result)


def test_repeated_frequencies_are_compared_one_by_one(analysed, monkeypatch):
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


def test_missing_uncertainty_is_a_different_number(analysed):
    def changed(content):
        content["headline"]["compensated"]["standard_uncertainty"] = None

    stored, result = analysed
    with pytest.raises(DataError, match="different numbers"):
        refuse_other_numbers(sealed_with(stored, changed), result)


def test_run_sealed_without_result_passes(analysed):
    stored, result = analysed
    refuse_other_numbers(replace(stored, result_document=None), result)


def test_different_revision_of_a_method_is_named(analysed):
    def changed(content):
        content["headline"]["compensated"]["value"] += 0.0015
        del content["revisions"]["analysis"]

    stored, result = analysed
    newer = replace(result, revisions={**result.revisions, "analysis": 7})
    with pytest.raises(DataError) as caught:
        refuse_other_numbers(sealed_with(stored, changed), newer)
    hint = "analysis has revision 7, the run was computed by revision 1; certify with the versions"
    assert caught.value.hint.startswith(hint)


def test_result_of_a_missing_package_is_refused(analysed, monkeypatch):
    monkeypatch.setattr("rigrunner.run.set_points._readers", tuple)
    with pytest.raises(DataError, match="reads points, no_load_points, compens"):
        refuse_other_numbers(*analysed)
