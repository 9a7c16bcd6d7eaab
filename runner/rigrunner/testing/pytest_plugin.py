"""Deprecated: the plugin is `rigrunner_testing.pytest_plugin`."""

pytest_plugins = ["rigrunner_testing.pytest_plugin"]
