"""A session with a server: reads, writes and describes nodes, for one caller at a time.

The age of values is taken by the computer's own clock: it is not asked when exchanges are played
back.
"""

from __future__ import annotations

import asyncio
import logging
import threading
from concurrent.futures import CancelledError
from contextlib import suppress
from datetime import UTC, datetime
from typing import TYPE_CHECKING, Any, TypeVar

from asyncua import ua

from rigrunner.api import (
    DeviceLostError,
    DeviceRejectedError,
    DeviceTimeoutError,
    find_unit,
)
from rigrunner_plugins.devices.opcua.opening import error_text, open_client, status

if TYPE_CHECKING:
    from collections.abc import Coroutine, Sequence
    from pathlib import Path
    from typing import Any

    from asyncua import Client, Node

    from rigrunner_plugins.devices.opcua.settings import NodeValue, OpcUaSettings
    from rigrunner_plugins.devices.opcua.types import Type

_T = TypeVar("_T")


class LoopThread:
    """Runs coroutines for callers that wait; nothing is left of it after `stop`."""

    def __init__(self, name: str) -> None:
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        self._thread.start()

    def do(self, work: Coroutine[Any, Any, _T], timeout_s: float) -> _T:
        """Return what it returns; raise what it raises, or TimeoutError."""
        future = asyncio.run_coroutine_threadsafe(asyncio.wait_for(work, timeout_s), self._loop)
        try:
            return future.result()
        except CancelledError as error:  # the library gave itself up
            raise ConnectionError("the connection was abandoned") from error

    def stop(self) -> None:
        """Cancel what still runs, and end the thread."""
        if self._thread.is_alive():
            with suppress(RuntimeError):  # it is ending by itself, and has closed its loop
                self._loop.call_soon_threadsafe(self._loop.stop)
            self._thread.join()

    def _run(self) -> None:
        asyncio.set_event_loop(self._loop)
        try:
            self._loop.run_forever()
        finally:
            tasks = asyncio.all_tasks(self._loop)
            for task in tasks:
                task.cancel()
            self._loop.run_until_complete(asyncio.gather(*tasks, return_exceptions=True))
            self._loop.run_until_complete(self._loop.shutdown_asyncgens())
            self._loop.close()


# what it would print on stderr is in our error messages
logging.getLogger("asyncua").addHandler(logging.NullHandler())

_STEPS_OF_CONNECTING = 6
"""Hello, channel, endpoints, session, activation and certificates: each waits for an answer."""
_STEPS_OF_DESCRIBING = 2
"""Types, rights and unit of a node are several answers, usually quick ones."""
_NO_SUCH_NODE = (
    "see its id in a browser of OPC UA: the number of a namespace may change, `nsu=URI;...` names"
    " it for good"
)
_BUILD_INFO = {
    "maker": "i=2263",
    "model": "i=2261",
    "firmware": "i=2264",
}
"""ManufacturerName, ProductName and SoftwareVersion of the server (OPC 10000-6, annex A)."""


class Session:
    """A connection to one server, with an event loop of its own."""

    def __init__(self, settings: OpcUaSettings, folder: Path) -> None:
        self._settings = settings
        self._folder = folder
        self._loop: LoopThread | None = None
        self._client: Client | None = None

    def open(self, timeout_s: float) -> None:
        """Connect; raise a DeviceError."""
        self._loop = LoopThread("opcua")
        within_s = min(timeout_s, _STEPS_OF_CONNECTING * self._settings.timeout)
        self._client = self._do("connect", open_client(self._settings, self._folder), within_s)

    def close(self) -> None:
        """End session, connection and thread."""
        client, self._client = self._client, None
        loop, self._loop = self._loop, None
        if loop is None:
            return
        try:
            if client is not None:
                loop.do(client.disconnect(), 2 * self._settings.timeout)
        except (OSError, ua.UaError):  # a connection that is lost cannot be ended politely
            pass
        finally:
            loop.stop()

    def identity(self) -> list[str]:
        """Return maker, model, serial and firmware as texts; '' if unknown."""
        identification = self._settings.identification
        nodes = [
            getattr(identification, part) or _BUILD_INFO.get(part)
            for part in ("maker", "model", "serial", "firmware")
        ]

        async def read(node: str) -> str:
            value = await (await self._node(node)).read_value()
            return "" if value is None else str(value)

        return [self._do(f"read {node}", read(node)) if node else "" for node in nodes]

    def describe(self, node: str) -> list[str]:
        """Return the type of its value, the symbol of its unit or '', and 'r' or 'rw'."""

        async def describe() -> list[str]:
            opcua_node = await self._node(node)
            value = await opcua_node.read_data_value(raise_on_bad_status=False)
            type_ = ua.VariantType.Null if value.Value is None else value.Value.VariantType
            if type_ is ua.VariantType.Null:  # there is no value yet
                type_ = await opcua_node.read_data_type_as_variant_type()
            rights = await opcua_node.get_user_access_level()
            writable = ua.AccessLevel.CurrentWrite in rights
            return [type_.name, await _unit(opcua_node), "rw" if writable else "r"]

        within_s = _STEPS_OF_DESCRIBING * self._settings.timeout
        return self._do(f"look at {node}", describe(), within_s)

    def read(self, node_values: Sequence[NodeValue]) -> list[float]:
        """Return the numbers of nodes, read together."""

        async def read() -> list[ua.DataValue]:
            nodes = [await self._node(value.node) for value in node_values]
            return await self._open_client().read_attributes(nodes, ua.AttributeIds.Value)

        request = f"read {', '.join(value.node for value in node_values)}"
        values = self._do(request, read())
        return [self._number(*pair) for pair in zip(node_values, values, strict=True)]

    def write(self, node: str, value: float, type_: Type) -> None:
        """Write a value of that type to a node."""

        async def write() -> ua.StatusCode:
            target = (await self._node(node)).nodeid
            # without timestamps: many servers refuse to have them written
            data = ua.DataValue(ua.Variant(value, ua.VariantType[type_]))
            results = await self._open_client().uaclient.write_attributes([target], [data])
            return results[0]

        result = self._do(f"write {value} to {node}", write())
        if not result.is_good():
            raise DeviceRejectedError(
                f"write {value} to {node}: the server says {status(result.value)}",
                hint="see the user's rights, the range of the node, and whether remote is enabled",
            )

    def _do(self, request: str, work: Coroutine[Any, Any, _T], within_s: float = 0.0) -> _T:
        if self._loop is None:
            work.close()
            raise DeviceLostError(f"{request}: not connected")
        try:
            return self._loop.do(work, within_s or self._settings.timeout)
        except TimeoutError as error:
            raise DeviceTimeoutError(
                f"{request}: no answer from {self._settings.endpoint}",
                hint="is the server running, and the cable connected?",
            ) from error
        except OSError as error:
            raise DeviceLostError(
                f"{request}: {self._settings.endpoint} closed the connection or was unplugged",
                hint="see server, network and cable",
            ) from error
        except ua.UaError as error:
            unknown = isinstance(error, ua.uaerrors.BadNodeIdUnknown)
            raise DeviceRejectedError(
                f"{request}: the server says {error_text(error)}",
                hint=_NO_SUCH_NODE if unknown else "",
            ) from error

    async def _node(self, node_id: str) -> Node:
        client = self._open_client()
        if node_id.startswith("nsu="):
            uri, _, rest = node_id.removeprefix("nsu=").partition(";")
            try:
                node_id = f"ns={await client.get_namespace_index(uri)};{rest}"
            except ValueError as error:
                raise DeviceRejectedError(f"the server has no namespace '{uri}'") from error
        return client.get_node(node_id)

    def _open_client(self) -> Client:
        if self._client is None:
            raise DeviceLostError("not connected")
        return self._client

    def _number(self, node_value: NodeValue, data: ua.DataValue) -> float:
        node = node_value.node
        if data.StatusCode is not None and not data.StatusCode.is_good():
            raise DeviceRejectedError(
                f"{node} has no good value: {status(data.StatusCode.value)}",
                hint="check the server and the source of the node",
            )
        value = None if data.Value is None else data.Value.Value
        if not isinstance(value, (bool, int, float)):
            shown = "nothing" if value is None else f"a {type(value).__name__}: {value!r:.40}"
            if isinstance(value, list):
                shown = "an array"
            raise DeviceRejectedError(f"{node} holds {shown}, expected a number")
        if node_value.stale is None:
            return float(value)
        if data.SourceTimestamp is None:
            raise DeviceRejectedError(
                f"{node_value.node} does not state the age of its value", hint="leave `stale` out"
            )
        age_s = (datetime.now(UTC) - data.SourceTimestamp).total_seconds()
        # Also one from the future: then the clocks do not agree, and no age is known.
        if abs(age_s) > node_value.stale:
            raise DeviceRejectedError(
                f"{node_value.node} has a value that is {age_s:.3g} s old, more than"
                f" {node_value.stale:g} s",
                hint="is it still measured, and do the clocks of both computers agree?",
            )
        return float(value)


async def _unit(node: Node) -> str:
    try:
        information = await (await node.get_child("0:EngineeringUnits")).read_value()
    except ua.UaStatusCodeError:  # it has none
        return ""
    if not isinstance(information, ua.EUInformation):
        return ""
    return symbol_of(information.NamespaceUri, information.UnitId, information.DisplayName.Text)


UNECE = "http://www.opcfoundation.org/UA/units/un/cefact"
_CODES = {
    "NU": "N·m",
    "D83": "mN·m",
    "NEW": "N",
    "B47": "kN",
    "HTZ": "Hz",
    "KHZ": "kHz",
    "RPM": "rpm",
    "C81": "rad",
    "C25": "mrad",
    "DD": "deg",
    "SEC": "s",
    "C26": "ms",
    "MIN": "min",
    "HUR": "h",
    "DAY": "d",
    "MTR": "m",
    "MMT": "mm",
    "4H": "µm",
    "C62": "1",
    "P1": "%",
    "KEL": "K",
    "CEL": "°C",
    "VLT": "V",
    "2Z": "mV",
    "AMP": "A",
    "4K": "mA",
    "KGM": "kg",
    "GRM": "g",
    "2A": "rad/s",
    "MTS": "m/s",
}


def unit_id(code: str) -> int:
    """Return the UnitId of a common code of UNECE Recommendation 20 (OPC 10000-8, 5.6.4.3).

    It is made of the characters of the code, each one byte, the first the highest.
    """
    return int.from_bytes(code.encode("ascii"), "big")


_BY_ID = {unit_id(code): symbol for code, symbol in _CODES.items()}


def symbol_of(namespace: str | None, number: int, text: str | None) -> str:
    """Return the symbol of the unit in a node's EngineeringUnits; '' if it is not known."""
    if namespace == UNECE and number in _BY_ID:
        return _BY_ID[number]
    unit_ = find_unit(text or "")
    return unit_.symbol if unit_ else ""
