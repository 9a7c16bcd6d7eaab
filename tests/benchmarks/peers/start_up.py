"""Prints the milliseconds of `python -m MODULE --help` in this environment, TIMES times."""

import importlib.util
import json
import subprocess
import sys
import time

module, times = sys.argv[1], int(sys.argv[2])
if importlib.util.find_spec(module) is None:
    raise ModuleNotFoundError(module)


def start() -> float:
    began = time.perf_counter()
    subprocess.run([sys.executable, "-E", "-m", module, "--help"], capture_output=True, check=False)
    return (time.perf_counter() - began) * 1e3


start()
sys.stdout.write(json.dumps([start() for _ in range(times)]) + "\n")
