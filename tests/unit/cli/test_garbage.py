"""A command collects garbage rarely, and leaves the objects that live at its end to the system."""

import gc
import subprocess
import sys

import pytest

from helpers_cli import call

AT_THE_END = """
import atexit, gc
from rigrunner.cli.main import main
atexit.register(lambda: print(gc.get_freeze_count(), len(gc.get_objects())))  # after main's own
main(["--version"])
"""


@pytest.fixture
def default_threshold():
    """The default of Python; the test run itself collects less often."""
    before = gc.get_threshold()
    gc.set_threshold(700, 10, 10)
    yield
    gc.set_threshold(*before)


@pytest.mark.usefixtures("default_threshold")
def test_command_raises_the_threshold_and_keeps_the_collector_on():
    call("--version")
    assert gc.isenabled()
    assert 10_000 <= gc.get_threshold()[0] <= 200_000


def test_objects_are_frozen_at_the_end_of_a_command():
    result = subprocess.run(
        [sys.executable, "-c", AT_THE_END], capture_output=True, text=True, check=True
    )
    frozen, others = map(int, result.stdout.split("\n")[1].split())
    assert frozen > 10_000
    assert others < 100
