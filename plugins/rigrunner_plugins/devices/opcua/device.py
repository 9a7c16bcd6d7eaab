"""Nodes of an OPC UA server, as channels and drives."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from rigrunner.api import (
    DeviceLostError,
    DeviceRejectedError,
    Driver,
    Identity,
)
from rigrunner.api.cleanup import do_all
from rigrunner.api.driver import check_patience
from rigrunner_plugins.devices.declared import channel_infos, drive_infos, refuse_other
from rigrunner_plugins.devices.extras import missing_package
from rigrunner_plugins.devices.opcua.types import TYPES, encode

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rigrunner.api import DeviceContext
    from rigrunner_plugins.devices.opcua.session import Session
    from rigrunner_plugins.devices.opcua.settings import (
        NodeValue,
        OpcUaChannel,
        OpcUaDrive,
        OpcUaSettings,
        ReadBack,
        Write,
    )
    from rigrunner_plugins.devices.opcua.types import Type

_PARTS = ("maker", "model", "serial", "firmware")


class OpcUa(Driver):
    """Reads nodes together, and writes set-points with the nodes that belong to them."""

    reconnects_after = (DeviceLostError,)  # each answer names its request

    def __init__(self, settings: OpcUaSettings, context: DeviceContext) -> None:
        super().__init__(context, channel_infos(settings.channels), drive_infos(settings.drives))
        check_patience(settings.timeout, context)
        self._settings = settings
        self._folder = context.folder
        self._opened: Session | None = None
        self._types: dict[str, Type] = {}

    def open(self, timeout_s: float) -> Identity:
        """Connect, identify the server, and compare each node with the station."""
        self.shut()
        self.exchange(f"connect to {self._settings.endpoint}", lambda: self._connect(timeout_s))
        identity = self._identify()
        self._types.clear()
        for node in self._settings.channels.values():
            self._compare(node)
        for drive in self._settings.drives.values():
            rights = self._compare(drive)
            try:
                drive.fits(self._types[drive.node])
            except ValueError as error:
                raise DeviceRejectedError(f"{drive.node}: {error}") from error
            if drive.read_back is not None:
                self._compare(drive.read_back)
            if "w" not in rights:
                raise DeviceRejectedError(
                    f"{drive.node} cannot be written",
                    hint="see the user's rights, and whether the server allows it at all",
                )
            for write in (*drive.run, *drive.stop):
                self._describe(write.node)
        return identity

    def shut(self) -> None:
        """Close the session."""
        if self._opened is not None:
            self._opened.close()
            self._opened = None

    def get(self, channel: str) -> float:
        """Return the present value of a channel."""
        return self.get_all([channel])[channel]

    def get_all(self, channels: Sequence[str]) -> dict[str, float]:
        """Return the present values, in one request."""
        nodes = {name: self._settings.channels[name] for name in channels}
        numbers = self._read(list(nodes.values()))
        return {name: nodes[name].to_si(value) for name, value in zip(nodes, numbers, strict=True)}

    def put(self, drive: str, value: float) -> None:
        """Write a set-point: with the nodes that let it run, or, to be safe, that stop it."""
        settings = self._settings.drives[drive]

        def write() -> None:
            self._write(settings.node, settings.from_si(value))

        if value == self._drives[drive].safe_value:
            # a stop that is refused must not keep the set-point up, nor the next stop from its turn
            do_all(*(partial(self._send_command, command) for command in settings.stop), write)
        else:
            write()
            for command in settings.run:
                self._send_command(command)

    def actual(self, drive: str) -> float:
        """Return the actual value of a drive."""
        settings = self._settings.drives[drive]
        back = settings.read_back or settings
        return back.to_si(self._read([back])[0])

    @property
    def _session(self) -> Session:
        if self._opened is None:
            raise DeviceLostError("not connected")
        return self._opened

    def _connect(self, timeout_s: float) -> None:
        try:
            from rigrunner_plugins.devices.opcua.session import Session  # noqa: PLC0415  (asyncua)
        except ModuleNotFoundError as error:
            raise missing_package((error.name or "asyncua").partition(".")[0], "opcua") from error
        self._opened = Session(self._settings, self._folder)
        self._opened.open(timeout_s)

    def _identify(self) -> Identity:
        values = self.exchange("read who it is", self._ask_identity)
        texts = dict.fromkeys(_PARTS, "") | dict(zip(_PARTS, values, strict=False))
        refuse_other(self._settings.endpoint, texts, self._settings.identification.expect)
        maker = texts["maker"] or "unknown"
        model, serial, firmware = (texts[part] or "not told" for part in _PARTS[1:])
        return Identity(maker, model, serial, firmware)

    def _ask_identity(self) -> list[str]:
        return self._session.identity()

    def _compare(self, node: OpcUaChannel | OpcUaDrive | ReadBack) -> str:
        """Raise DeviceRejectedError unless type and unit are as declared; return the rights."""
        type_, symbol, rights = self._describe(node.node)
        if node.type not in (None, type_):
            raise DeviceRejectedError(
                f"{node.node} is a {type_}, the station states {node.type}",
                hint="is it the right node? `type` may be left out",
            )
        # A scale may well change the unit.
        is_unscaled = (node.scale, node.offset) == (1.0, 0.0)
        if self._settings.check_units and symbol and is_unscaled and node.unit != symbol:
            raise DeviceRejectedError(
                f"{node.node} is in {symbol}, as its EngineeringUnits say;"
                f" the station says {node.unit}",
                hint="correct `unit`, or write `check_units: no` if the server is wrong",
            )
        return rights

    def _describe(self, node: str) -> tuple[Type, str, str]:
        description = self.exchange(f"describe {node}", lambda: self._session.describe(node))
        type_ = next((name for name in TYPES if description and description[0] == name), None)
        if type_ is None or len(description) != 3:  # noqa: PLR2004  (type, unit, rights)
            content = description[0] if description else "nothing"
            raise DeviceRejectedError(f"{node} holds {content}, expected a number or a Boolean")
        self._types[node] = type_
        return type_, description[1], description[2]

    def _read(self, nodes: Sequence[NodeValue]) -> list[float]:
        request = f"read {', '.join(node.node for node in nodes)}"
        numbers = self.exchange(request, lambda: self._session.read(nodes))
        if len(numbers) != len(nodes):  # of a played-back exchange
            raise DeviceRejectedError(f"{request}: {len(numbers)} came, expected {len(nodes)}")
        return numbers

    def _send_command(self, command: Write) -> None:
        self._write(command.node, command.value)
        self.clock.sleep(command.wait)

    def _write(self, node: str, number: float) -> None:
        type_ = self._types[node]
        try:
            value = encode(number, type_)
        except ValueError as error:
            raise DeviceRejectedError(f"write to {node}: {error}") from error
        self.exchange(f"write {value} to {node}", lambda: self._session.write(node, value, type_))
