"""Drives yaml-language-server over its standard streams, as an editor does."""

from __future__ import annotations

import json
import subprocess
from typing import TYPE_CHECKING, Any, Self

if TYPE_CHECKING:
    from pathlib import Path

SETTINGS = {
    "yaml": {
        "validate": True,
        "hover": True,
        "completion": True,
        "schemaStore": {"enable": False},  # no network: our schemas are beside the files
    }
}


class YamlServer:
    """One server for the files of one folder."""

    def __init__(self, program: str, folder: Path) -> None:
        self._process = subprocess.Popen(
            [program, "--stdio"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
        )
        self._next_id = 0
        self.folder = folder

    def __enter__(self) -> Self:
        capabilities = {
            "workspace": {"configuration": True},
            "textDocument": {
                "hover": {"contentFormat": ["markdown"]},
                "completion": {
                    "completionItem": {"snippetSupport": True, "documentationFormat": ["markdown"]}
                },
                "publishDiagnostics": {},
            },
        }
        self.request(
            "initialize",
            {"processId": None, "rootUri": self.folder.as_uri(), "capabilities": capabilities},
        )
        self._send({"method": "initialized", "params": {}})
        self._send({"method": "workspace/didChangeConfiguration", "params": {"settings": SETTINGS}})
        return self

    def __exit__(self, *_: object) -> None:
        try:
            self.request("shutdown", None)
            self._send({"method": "exit"})
            self._process.wait(timeout=100)
        finally:
            self._process.kill()
            self._process.communicate()

    def open(self, path: Path, text: str) -> list[dict[str, Any]]:
        """Open a text as that file, which need not exist; return its diagnostics.

        A path can be opened once: diagnostics do not name the version of their text.
        """
        uri = path.as_uri()
        document = {"uri": uri, "languageId": "yaml", "version": 1, "text": text}
        self._send({"method": "textDocument/didOpen", "params": {"textDocument": document}})
        while True:
            message = self._receive()
            published = message.get("method") == "textDocument/publishDiagnostics"
            if published and message["params"]["uri"] == uri:
                return list(message["params"]["diagnostics"])

    def completions(self, path: Path, line: int, column: int) -> list[dict[str, Any]]:
        """Return the completions at a place (from 0) of an open file."""
        answer = self._at("textDocument/completion", path, line, column)
        return list(answer["items"] if isinstance(answer, dict) else answer or [])

    def hover(self, path: Path, line: int, column: int) -> str:
        """Return the hover text at a place (from 0) of an open file."""
        answer = self._at("textDocument/hover", path, line, column)
        return str(answer["contents"]["value"]) if answer else ""

    def _at(self, method: str, path: Path, line: int, column: int) -> Any:
        place = {"line": line, "character": column}
        return self.request(method, {"textDocument": {"uri": path.as_uri()}, "position": place})

    def request(self, method: str, params: Any) -> Any:
        """Return the answer to a request."""
        self._next_id += 1
        self._send({"id": self._next_id, "method": method, "params": params})
        while True:
            message = self._receive()
            if message.get("id") == self._next_id and "method" not in message:
                assert "error" not in message, message["error"]
                return message["result"]

    def _send(self, message: dict[str, Any]) -> None:
        content = json.dumps({"jsonrpc": "2.0", **message}).encode()
        self._process.stdin.write(b"Content-Length: %d\r\n\r\n%s" % (len(content), content))
        self._process.stdin.flush()

    def _receive(self) -> dict[str, Any]:
        length = 0
        while (header := self._process.stdout.readline().strip()) or not length:
            assert header or self._process.poll() is None, "the server has gone"
            if header.lower().startswith(b"content-length:"):
                length = int(header.split(b":")[1])
        message: dict[str, Any] = json.loads(self._process.stdout.read(length))
        if "method" in message and "id" in message:
            self._answer(message)
        return message

    def _answer(self, request: dict[str, Any]) -> None:
        if request["method"] == "workspace/configuration":
            items = request["params"]["items"]
            result: Any = [SETTINGS.get(item.get("section")) for item in items]
        else:
            result = None
        self._send({"id": request["id"], "result": result})
