"""A small instrument that speaks SCPI over TCP: queries with an answer, and commands."""

from __future__ import annotations

import socketserver
import threading
from dataclasses import dataclass
from importlib.resources import files
from string import Template
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

NO_ERROR = '0,"No error"'
UNDEFINED_HEADER = '-113,"Undefined header"'
ILLEGAL_PARAMETER = '-224,"Illegal parameter value"'


@dataclass(frozen=True)
class Bench:
    """Instruments that listen on this machine."""

    name: str
    """That of its station in this folder."""
    ports: Mapping[str, int]
    """Where they listen, by instrument."""

    def station(self) -> str:
        """Return the text of the station that binds these instruments."""
        folder = files("rigrunner_plugins.loopback")
        text = folder.joinpath(f"{self.name}_station.yaml").read_text("utf-8")
        ports = {f"{name}_port": port for name, port in self.ports.items()}
        return Template(text).substitute(ports)


class _Conversation(socketserver.StreamRequestHandler):
    """One controller's connection: program messages in, response messages out, LF at the end."""

    server: ScpiServer

    def handle(self) -> None:
        errors: list[str] = []
        for line in self.rfile:
            header, _, argument = line.decode("ascii", errors="replace").strip().partition(" ")
            if header == "SYST:ERR?":
                answer = errors.pop(0) if errors else NO_ERROR
                self.wfile.write(f"{answer}\n".encode("ascii"))
            elif header in self.server.queries and not argument:
                self.wfile.write(f"{self.server.queries[header]()}\n".encode("ascii"))
            elif header in self.server.commands:
                try:
                    self.server.commands[header](float(argument))
                except ValueError:
                    errors.append(ILLEGAL_PARAMETER)
            else:
                errors.append(UNDEFINED_HEADER)


class ScpiServer(socketserver.ThreadingTCPServer):
    """An instrument's network socket on a free port of 127.0.0.1, as a context manager.

    It has a thread of its own. Raises OSError where there is no free port.
    """

    allow_reuse_address = True
    daemon_threads = True

    def __init__(
        self,
        queries: Mapping[str, Callable[[], str]],
        commands: Mapping[str, Callable[[float], None]] | None = None,
    ) -> None:
        self.queries = dict(queries)
        self.commands = dict(commands or {})
        super().__init__(("127.0.0.1", 0), _Conversation)
        threading.Thread(target=self.serve_forever, daemon=True).start()

    @property
    def port(self) -> int:
        """Where it listens."""
        return int(self.server_address[1])

    def __exit__(self, *_: object) -> None:
        self.shutdown()
        self.server_close()
