"""Several stored runs at the panel: overlays and charts."""

from __future__ import annotations

from statistics import fmean
from types import SimpleNamespace

import numpy as np
import pytest
from starlette.testclient import TestClient

from e2e.helpers_trends import store_results
from rigrunner.runfile import read
from rigrunner_fleet.archive.location import FILE
from rigrunner_panel.overlay import result_rows
from rigrunner_panel.web.app import make_app
from rigrunner_panel.web.panel import Panel, Settings

CLIENT = {"X-Rigrunner-Client": "client-ann"}
TORQUES = [0.70 + 0.001 * (5 * day % 11) for day in range(20)]
HIGH = 0.90
D2 = 1.128
"""For moving ranges of two values (ISO 7870-2, table 2)."""


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    folder = tmp_path_factory.mktemp("lab") / "runs"
    folder.mkdir()
    store_results(folder, [*TORQUES, HIGH], recordings=1)
    return folder


@pytest.fixture
def client(runs):
    panel = Panel(settings=Settings(runs=runs, procedures=runs.parent))
    app = make_app(panel)
    with TestClient(app, base_url="http://127.0.0.1:8750", headers=CLIENT) as client:
        yield client


def test_archive_is_updated_and_lists_its_quantities(client, runs):
    assert not (runs / FILE).exists()
    updated = client.post("/api/v1/archive/update", json={}).json()
    assert (updated["runs"], updated["new"], updated["unreadable"]) == (21, 21, 0)
    assert client.post("/api/v1/archive/update", json={}).json()["new"] == 0
    items = client.get("/api/v1/archive/quantities").json()["items"]
    assert items[0] == "torque"
    assert "template_inverse/inertia" in items
    assert len(set(items)) == len(items)


def test_chart_has_baseline_limits_and_names_runs_beyond_them(client):
    client.post("/api/v1/archive/update", json={})
    study = client.get("/api/v1/trend", params={"quantity": "torque"}).json()
    (chart,) = study["charts"]
    sigma = fmean(np.abs(np.diff(TORQUES))) / D2
    assert chart["centre"] == pytest.approx(fmean(TORQUES))
    assert chart["upper"] == pytest.approx(fmean(TORQUES) + 3 * sigma, rel=1e-3)
    assert [alarm["run"] for alarm in chart["alarms"]] == ["day-20"]
    assert chart["alarms"][0]["value"] == HIGH
    shown = chart["figure"]["series"]
    assert [point["y"] for point in shown[0]["points"]] == pytest.approx([*TORQUES, HIGH])
    assert [(point["x"], point["y"]) for point in shown[1]["points"]] == [(21, HIGH)]
    assert {mark["at"] for mark in chart["figure"]["marks"]} == {
        chart["centre"], chart["lower"], chart["upper"],
    }  # fmt: skip


@pytest.mark.parametrize(
    ("query", "status"),
    [
        ({"quantity": "torque", "by": "nothing"}, 400),
        ({"quantity": "torque", "chart": "pie"}, 400),
        ({"quantity": "torque", "baseline": "two"}, 422),
        ({"quantity": "none such"}, 422),
    ],
)
def test_invalid_trend_query_is_refused_with_a_message(client, query, status):
    client.post("/api/v1/archive/update", json={})
    answer = client.get("/api/v1/trend", params=query)
    assert answer.status_code == status
    assert answer.json()["message"]


def test_group_of_too_few_runs_gives_a_reason_not_an_error(client):
    client.post("/api/v1/archive/update", json={})
    answer = client.get("/api/v1/trend", params={"quantity": "torque", "baseline": "200"})
    assert (answer.status_code, answer.json()["charts"]) == (200, [])
    (reason,) = answer.json()["not_charted"].values()
    assert reason == "there are 21 values, and the baseline is the first 200"


def test_overlay_shows_results_with_their_uncertainty(client, runs):
    names = sorted(path.name for path in runs.iterdir() if path.is_dir())[:2]
    overlay = client.get("/api/v1/overlay", params={"runs": ",".join(names)}).json()
    torque = overlay["results"][0]
    assert [series["name"] for series in torque["series"]] == names
    # set-points of the stored document: 10 Hz and 20 Hz, f/1000 N·m above the headline
    first = torque["series"][0]["points"]
    assert [(point["x"], point["y"], point["U"]) for point in first] == [
        (10.0, pytest.approx(TORQUES[0] + 0.01), 0.01),
        (20.0, pytest.approx(TORQUES[0] + 0.02), 0.01),
    ]
    recording, channels = next(iter(overlay["recordings"].items()))
    query = {"runs": ",".join(names), "recording": recording, "channel": channels[0]}
    curve = client.get("/api/v1/overlay", params=query).json()["curve"]
    stored = read(runs / names[0]).recordings[0]
    values = np.asarray(stored.channels[channels[0]])
    shown = [point["y"] for point in curve["series"][0]["points"]]
    assert (min(shown), max(shown)) == pytest.approx((values.min(), values.max()))
    assert len(curve["series"]) == 2


def test_result_without_set_point_has_one_value_per_run():
    def run(value, *, wear=None):
        def estimate(number):
            return {"value": number, "expanded_uncertainty_95": 0.1, "unit": "V"}

        results = [
            {"name": "ripple", "coordinates": {"state": "slow"}, "estimate": estimate(value)},
            {"name": "ripple", "coordinates": {"current": {"value": 2.0, "unit": "A"}},
             "estimate": estimate(9.0)},
        ]  # fmt: skip
        if wear is not None:
            results.append({"name": "wear", "coordinates": {}, "estimate": estimate(wear)})
        return SimpleNamespace(result_document={"results": results})

    assert result_rows({"one": run(1.0), "two": run(2.0, wear=3.0)}) == [
        ("ripple at state = slow", "V", {"one": (1.0, 0.1), "two": (2.0, 0.1)}),
        ("wear", "V", {"two": (3.0, 0.1)}),
    ]


@pytest.mark.parametrize("names", ["", ",".join("abcdefg"), "../../etc", "none-such"])
def test_overlay_of_invalid_runs_is_refused(client, names):
    assert client.get("/api/v1/overlay", params={"runs": names}).status_code in (400, 404)
