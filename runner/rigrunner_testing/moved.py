"""New places of the conformance kit of Rigrunner 0.1.0; `rigrunner.moved` forwards them."""

MOVED = {
    "rigrunner.testing": "rigrunner_testing",
    "rigrunner.testing.pytest_plugin": "rigrunner_testing.pytest_plugin",
}
