from rigrunner.procedure.kinds import installed_kinds
from rigrunner.registry import loading
from rigrunner.run.checked import checked_alone
from rigrunner.run.locate import find_procedure


def test_check_loads_plugins_once(monkeypatch):
    loads, load = [], loading._load
    monkeypatch.setattr(loading, "_load", lambda *args: loads.append(1) or load(*args))
    installed_kinds.cache_clear()
    assert checked_alone(find_procedure("starting_torque_1000n")).model.id
    assert len(loads) == 1
