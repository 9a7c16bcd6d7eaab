from rigrunner.procedure.kinds import installed_kinds
from rigrunner.registry import loading
from rigrunner.run.checked import checked_alone
from rigrunner.run.locate import find_procedure


def test_a_check_loads_the_plugins_once(monkeypatch):
    loaded, plain = [], loading._loaded
    monkeypatch.setattr(loading, "_loaded", lambda *asked: loaded.append(1) or plain(*asked))
    installed_kinds.cache_clear()
    assert checked_alone(find_procedure("starting_torque_1000n")).model.id
    assert len(loaded) == 1
