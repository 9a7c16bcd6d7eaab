"""A `rigrunner` for the shells of tests that is imported once and forked for each command.

The pages have some two hundred commands, and importing what each needs takes longer than
most of them. Commands that run until interrupted are started directly.
"""

from __future__ import annotations

import json
import os
import select
import socket
import stat
import subprocess
import sys
import tempfile
from contextlib import contextmanager, suppress
from importlib import import_module
from pathlib import Path

from rigrunner.cli.main import main

ITSELF = Path(__file__).resolve()
COMMAND = str(Path(sys.executable).parent / "rigrunner")
FOR_ITSELF = {"panel", "jog", "doctor"}
IMPORTED_ONCE = (
    "scipy.ndimage",
    "scipy.optimize",
    "scipy.special",
    "rigrunner.run.record",
    "rigrunner.run.stored",
    "rigrunner.documents.certifying.certify",
    "rigrunner_bearings.hooks",
    "rigrunner_plugins.hooks",
    "rigrunner_reports.hooks",
    "rigrunner_reports.render",
    "rigrunner_reports.certificate.render",
)
CLIENT = """#!{python} -ISE
import json, os, socket, sys
real = [{command!r}, *sys.argv[1:]]
if not sys.argv[1:] or sys.argv[1] in {for_itself!r} or "--workers" in sys.argv:
    os.execv(real[0], real)
server = socket.socket(socket.AF_UNIX)
server.connect({address!r})
request = json.dumps([sys.argv[1:], os.getcwd(), dict(os.environ)]).encode()
socket.send_fds(server, [len(request).to_bytes(4, "big")], [0, 1, 2])
server.sendall(request)
answer = server.recv(1)
sys.exit(answer[0] if answer else 70)
"""


@contextmanager
def served_command():
    """Yield a folder for PATH that holds the command, which is served until the block ends."""
    with tempfile.TemporaryDirectory(prefix="rr-") as name:
        folder, address = Path(name) / "bin", str(Path(name) / "s")
        folder.mkdir()
        text = CLIENT.format(
            python=sys.executable, command=COMMAND, for_itself=FOR_ITSELF, address=address
        )
        (folder / "rigrunner").write_text(text, encoding="utf-8")
        (folder / "rigrunner").chmod(stat.S_IRWXU)
        program = [sys.executable, ITSELF, address]
        with subprocess.Popen(program, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as server:
            assert server.stdout.readline() == b"serving\n"
            yield folder
            server.stdin.close()  # it ends with its input


def _serve(address: str) -> None:
    """Fork for each connection until the input ends."""
    for module in IMPORTED_ONCE:
        import_module(module)
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(address)
        listener.listen(64)
        os.write(1, b"serving\n")
        while listener in select.select([0, listener], [], [])[0]:
            connection, _ = listener.accept()
            if os.fork() == 0:
                _answer(connection)
            connection.close()
            _reap(os.WNOHANG)
    _reap(0)


def _reap(options: int) -> None:
    with suppress(ChildProcessError):
        while os.waitpid(-1, options)[0]:
            pass


def _answer(connection: socket.socket) -> None:
    """Run the command in a process of its own, and send the client its exit code."""
    size, streams, _, _ = socket.recv_fds(connection, 4, 3)
    with connection.makefile("rb") as request:
        arguments, folder, environment = json.loads(request.read(int.from_bytes(size, "big")))
    command = os.fork()
    if command == 0:
        connection.close()
        for number, stream in enumerate(streams):
            os.dup2(stream, number)
            os.close(stream)
        os.chdir(folder)
        os.environ.clear()
        os.environ.update(environment)
        sys.path[:0] = filter(None, environment.get("PYTHONPATH", "").split(os.pathsep))
        sys.argv = ["rigrunner", *arguments]
        sys.exit(main(arguments))
    _, status = os.waitpid(command, 0)
    connection.send(bytes([os.waitstatus_to_exitcode(status) % 256]))
    os._exit(0)


if __name__ == "__main__":
    _serve(sys.argv[1])
