"""A real OPC UA server on loopback, with a motor that follows its set-point."""

from __future__ import annotations

import asyncio
import threading
from datetime import UTC, datetime, timedelta
from pathlib import Path

from asyncua import Server, ua
from asyncua.crypto.cert_gen import setup_self_signed_certificate
from asyncua.crypto.permission_rules import User, UserRole
from cryptography.x509.oid import ExtendedKeyUsageOID

from rigrunner.api.devices import DeviceContext
from rigrunner.clock import WallClock
from rigrunner.registry import load_registry

NAMESPACE = "urn:rigrunner:test"
APPLICATION = "urn:rigrunner:client"
UNECE = "http://www.opcfoundation.org/UA/units/un/cefact"
# UnitIds of the OPC Foundation's table UNECE_to_OPCUA.csv
NEWTON_METRE, HERTZ, CELSIUS = 20053, 4740186, 4408652
PASSWORD = "s3cret"  # noqa: S105  (of the server in this file)
_TICK_S = 0.02

DRIVE = {
    "node": "ns=2;s=Set",
    "unit": "Hz",
    "min": "0 Hz",
    "max": "35 Hz",
    "safe": "0 Hz",
    "tolerance": "0.05 Hz",
    "rate": "200 Hz/s",
    "settle": "1 s",
    "sets_cycle_frequency": "yes",
    "read_back": {"node": "ns=2;s=Actual", "unit": "Hz"},
    "run": [{"node": "ns=2;s=Enable", "value": 1}],
    "stop": [{"node": "ns=2;s=Enable", "value": 0}],
}


class Users:
    """Who may log in."""

    def get_user(self, iserver, username=None, password=None, certificate=None):  # noqa: ARG002
        accepted = username is None or (username, password) == ("lab", PASSWORD)
        return User(role=UserRole.User) if accepted else None


class Bench:
    """The server, in its own thread, on a free port."""

    def __init__(self, folder: Path):
        self.folder = folder
        self.port = 0
        self._ready, self._loop = threading.Event(), None
        self._ended = None
        self._thread = threading.Thread(target=lambda: asyncio.run(self._run()), daemon=True)

    def start(self):
        self._thread.start()
        assert self._ready.wait(300)
        return self

    def stop(self):
        if self._thread.is_alive():
            self._loop.call_soon_threadsafe(self._ended.set)
            self._thread.join(30)

    @property
    def endpoint(self):
        return f"opc.tcp://127.0.0.1:{self.port}/bench"

    def put(self, name, value, type_=None, status=ua.StatusCodes.Good, age_s=0.0):
        """Give a node a value, from a thread of a test."""
        data = ua.DataValue(
            ua.Variant(value, type_) if type_ else ua.Variant(value),
            ua.StatusCode(status),
            datetime.now(UTC) - timedelta(seconds=age_s),
        )
        self._do(self.nodes[name].write_attribute(ua.AttributeIds.Value, data))

    def value(self, name):
        return self._do(self.nodes[name].read_value())

    def allow(self, name, *, writing):
        self._do(self.nodes[name].set_writable(writing))

    def _do(self, work):
        return asyncio.run_coroutine_threadsafe(work, self._loop).result(10)

    async def _run(self):
        self._loop, self._ended = asyncio.get_running_loop(), asyncio.Event()
        server = Server(user_manager=Users())
        await server.init()
        server.set_endpoint("opc.tcp://127.0.0.1:0/bench")
        await self._certify(server)
        await self._make_nodes(server)
        async with server:
            self.port = server.bserver._server.sockets[0].getsockname()[1]
            self._ready.set()
            while not self._ended.is_set():
                await self._tick()
                await asyncio.sleep(_TICK_S)

    async def _certify(self, server):
        for name, uri, use in (
            ("server", server._application_uri, ExtendedKeyUsageOID.SERVER_AUTH),
            ("client", APPLICATION, ExtendedKeyUsageOID.CLIENT_AUTH),
        ):
            key, certificate = self.folder / f"{name}.pem", self.folder / f"{name}.der"
            await setup_self_signed_certificate(key, certificate, uri, "localhost", [use], {})
        await server.load_certificate(str(self.folder / "server.der"))
        await server.load_private_key(str(self.folder / "server.pem"))
        server.set_security_policy(
            [
                ua.SecurityPolicyType.NoSecurity,
                ua.SecurityPolicyType.Basic256Sha256_Sign,
                ua.SecurityPolicyType.Basic256Sha256_SignAndEncrypt,
            ]
        )

    async def _make_nodes(self, server):
        index = await server.register_namespace(NAMESPACE)
        nodes = {
            "Torque": (1.25, ua.VariantType.Double, (NEWTON_METRE, "N·m")),
            "Temperature": (21.5, ua.VariantType.Float, (CELSIUS, "°C")),
            "Count": (7, ua.VariantType.Int16, None),
            "Label": ("bench 7", ua.VariantType.String, None),
            "Many": ([1.0, 2.0], ua.VariantType.Double, None),
            "Set": (0.0, ua.VariantType.Float, (HERTZ, "Hz")),
            "Actual": (0.0, ua.VariantType.Float, (0, "Hz")),
            "Enable": (False, ua.VariantType.Boolean, None),
            "Coarse": (0, ua.VariantType.UInt16, None),
            "Locked": (0.0, ua.VariantType.Double, None),
        }
        self.nodes = {}
        for name, (value, type_, unit) in nodes.items():
            node = await server.nodes.objects.add_variable(
                ua.NodeId(name, index), ua.QualifiedName(name, index), value, type_
            )
            self.nodes[name] = node
            if unit:
                await node.add_property(
                    ua.NodeId(f"{name}.Unit", index),
                    ua.QualifiedName("EngineeringUnits", 0),
                    ua.EUInformation(
                        UNECE if unit[0] else None, unit[0], ua.LocalizedText(unit[1])
                    ),
                )
        for name in ("Set", "Enable", "Coarse"):
            await self.nodes[name].set_writable()

    async def _tick(self):
        """Move the motor to its set-point while it is enabled."""
        enabled = await self.nodes["Enable"].read_value()
        set_point = await self.nodes["Set"].read_value() if enabled else 0.0
        await self.nodes["Actual"].write_value(set_point, ua.VariantType.Float)


def device(settings, folder=Path(), clock=None):
    """Return the device as a station would make it."""
    context = DeviceContext("plc", clock or WallClock(), folder)
    return load_registry().make_device("opcua", settings, context)
