"""A panel served for real, and a client that follows its state as a screen does."""

from __future__ import annotations

import json
import re
import struct
import subprocess
import sys
import threading
import time
from contextlib import ExitStack, contextmanager, suppress

import httpx
import numpy as np
import psutil
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

PROGRAM = "import sys; from rigrunner.cli.main import main; sys.exit(main())"
PATIENCE_S = 200.0
INPUTS = {"specimen": "SN-1", "type": "GE20", "lot": "L-7", "operator": "Ann"}
"""All inputs of the shipped procedure of the starting torque."""


class Server:
    """`rigrunner panel` as a process of its own."""

    def __init__(self, lab, runs, *options):
        command = ["panel", "--port", "0", "--no-browser", "--procedures", lab, "--runs", runs]
        self.process = subprocess.Popen(
            [sys.executable, "-c", PROGRAM, *map(str, command), *options],
            stderr=subprocess.PIPE,
            text=True,
        )
        self.output = []
        first_line = self.process.stderr.readline()
        if not first_line.startswith("Panel: "):
            _, output = self.process.communicate(timeout=PATIENCE_S)
            raise AssertionError(first_line + output)
        self.address = re.search(r"http://\S+?:\d+", first_line)[0]
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def end(self, signal_number=None):
        """Wait for its end; return its exit code and its whole output."""
        if signal_number is not None:
            self.process.send_signal(signal_number)
        code = self.process.wait(PATIENCE_S)
        self._reader.join(PATIENCE_S)
        self.process.stderr.close()
        return code, "".join(self.output)

    def _read(self):
        with suppress(ValueError):
            self.output.extend(iter(self.process.stderr.readline, ""))


class Screen:
    """A client with an id of its own that applies every delta of one rig."""

    def __init__(self, server, client, rig=None):
        parameters = {} if rig is None else {"rig": rig}  # only one of several has to be named
        self.http = httpx.Client(
            base_url=server.address,
            headers={"X-Rigrunner-Client": client},
            params=parameters,
            timeout=PATIENCE_S,
        )
        address = server.address.replace("http", "ws", 1)
        query = httpx.QueryParams({"client": client} | parameters)
        events = connect(f"{address}/api/v1/events?{query}", max_size=None)
        self._stack = ExitStack()
        self._socket = self._stack.enter_context(events)
        self.state = {}
        self.frames = []
        self.rigs = []
        self.events = []
        self.phases = []
        self.is_closed = False
        self._news = threading.Condition()
        threading.Thread(target=self._follow, daemon=True).start()
        self.until(bool)

    def post(self, path, /, status=200, **body):
        """Post a request and return the answer; its status must be as expected."""
        answer = self.http.post(f"/api/v1/{path}", json=body)
        assert answer.status_code == status, answer.text
        return answer.json()

    def until(self, condition, patience_s=PATIENCE_S):
        """Wait until the state meets the condition, and return it."""
        with self._news:
            is_reached = self._news.wait_for(lambda: condition(self.state), patience_s)
        shown = {key: self.state.get(key) for key in ("phase", "asked", "finished", "alarms")}
        assert is_reached, f"still {shown}"
        return self.state

    def phase(self, *phases):
        """Wait for one of these phases."""
        return self.until(lambda state: state.get("phase") in phases)

    def answer(self, text="yes"):
        """Answer the next prompt."""
        prompt = self.until(lambda state: state["prompt"])["prompt"]
        self.post("run/answer", prompt=prompt["id"], text=text)
        self.until(lambda state: state["prompt"] != prompt)

    def close(self):
        """Disconnect without notice, like a browser that is closed."""
        self.is_closed = True
        self._stack.close()
        self.http.close()

    def _follow(self):
        with suppress(ConnectionClosed):
            for message in self._socket:
                self._take(message)

    def _take(self, message):
        with self._news:
            if isinstance(message, bytes):
                self.frames.append(parse_frame(message))
            elif (update := json.loads(message))["type"] == "state":
                self.state = update["state"]
            elif update["type"] == "event":
                self.events.append(update)
            elif update["type"] == "rigs":
                self.rigs = update["rigs"]
            else:
                assert update["seq"] == self.state["seq"] + 1
                self.state = {**self.state, **update["changes"], "seq": update["seq"]}
            if self.state.get("phase") not in self.phases[-1:]:
                self.phases.append(self.state.get("phase"))
            self._news.notify_all()


@contextmanager
def served(lab, runs, *options):
    """Yield a served panel, which is killed at the end if it still runs."""
    server = Server(lab, runs, *options)
    try:
        yield server
    finally:
        server.process.kill()
        server.end()


def ready(screen, procedure, station="station.yaml", name="Ann"):
    """Take control, check the rig, and return the arguments of a start."""
    screen.post("control", name=name, take_over=True)
    earlier = screen.state["preflight"]
    screen.post("preflight", 202, procedure=procedure, station=station)
    screen.until(lambda state: _is_done_since(earlier, state["preflight"]))
    return {"procedure": procedure, "station": station}


def _is_done_since(earlier, preflight):
    when = earlier and earlier["checked_utc"]
    return preflight and preflight["done"] and preflight["checked_utc"] != when


def process_is_gone(pid, patience_s=PATIENCE_S):
    """Wait until a process that is no child of ours has ended."""
    until_s = time.monotonic() + patience_s
    while time.monotonic() < until_s:
        try:
            if psutil.Process(pid).status() == psutil.STATUS_ZOMBIE:
                return True
        except psutil.NoSuchProcess:
            return True
        time.sleep(0.05)
    return False


def rig_process(server):
    """Return the PID of the process that controls the rig."""
    started = started_by(server.process.pid).items()
    return next(pid for pid, command in started if "panel.jobs.main" in command)


def started_by(pid):
    """Return the command lines of the running children of a process, by PID."""
    commands = {}
    for child in psutil.Process(pid).children():
        with suppress(psutil.NoSuchProcess):
            commands[child.pid] = " ".join(child.cmdline())
    return commands


def parse_frame(content):
    """Return header and arrays of a frame, as docs/reference/panel-api.md describes it."""
    (length,) = struct.unpack_from("<I", content)
    header = json.loads(content[4 : 4 + length])
    arrays, offset = {}, 4 + length
    for name, count in header["arrays"]:
        arrays[name] = np.frombuffer(content, "<f4", count, offset)
        offset += 4 * count
    return header, arrays
