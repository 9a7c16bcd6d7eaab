"""The threads of linear algebra in the command line."""

from __future__ import annotations

import os

import pytest

from rigrunner.blas import ONE_THREAD
from rigrunner.cli.main import main


@pytest.mark.parametrize("threads", [None, "4"])
def test_linear_algebra_has_one_thread_unless_the_environment_sets_more(monkeypatch, threads):
    for name in ONE_THREAD:
        monkeypatch.delenv(name, raising=False)
    if threads is not None:
        monkeypatch.setenv("OPENBLAS_NUM_THREADS", threads)
    main(["--version"])
    assert os.environ["OPENBLAS_NUM_THREADS"] == (threads or "1")
    assert os.environ["OMP_NUM_THREADS"] == "1"
