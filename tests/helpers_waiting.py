"""Waiting for a condition, in place of a fixed time."""

from __future__ import annotations

import time


def wait_until(condition, patience_s=60.0):
    end_s = time.monotonic() + patience_s
    while not condition():
        assert time.monotonic() < end_s, "it never came"
        time.sleep(0.005)
