"""What a station says of nodes on an OPC UA server."""

from __future__ import annotations

import re
from typing import Annotated, Literal, Self
from urllib.parse import urlsplit

from pydantic import AfterValidator, Field, WithJsonSchema, model_validator

from rigrunner.api import Duration, ListOf, PositiveDuration, Settings, YesNo
from rigrunner_plugins.devices.declared import (
    DeclaredChannel,
    DeclaredDrive,
    DeclaredQuantity,
    ExpectedIdentity,
    QuantityName,
)
from rigrunner_plugins.devices.opcua.types import Type, encode, step

_NODE_ID = r"^(ns=[0-9]+;|nsu=[^;]+;)?(i=[0-9]+|s=.+|g=[0-9a-fA-F-]{36})$"
_PORT = 4840
"""Of OPC UA, where an endpoint says none."""
_ENDPOINT = r"^opc\.tcp://[^\s@]+$"


def _node_id(written: str) -> str:
    if not re.match(_NODE_ID, written):
        raise ValueError(
            f"'{written}' is not a node id; expected such as ns=2;s=Rig.Torque, i=2258 or"
            " nsu=urn:acme;s=Torque"
        )
    return written


def _endpoint(written: str) -> str:
    if not re.match(_ENDPOINT, written):
        raise ValueError(
            f"'{written}' is not an endpoint; expected such as opc.tcp://192.168.1.30:4840,"
            " without user and password"
        )
    return written


NodeId = Annotated[
    str, AfterValidator(_node_id), WithJsonSchema({"type": "string", "pattern": _NODE_ID})
]
"""As OPC UA writes it: `ns=2;s=Rig.Torque`, `i=2258`, or by namespace: `nsu=urn:acme;s=Torque`."""


class Security(Settings):
    """A secure channel: both ends show certificates, and messages are signed."""

    policy: Literal["Basic256Sha256", "Aes128Sha256RsaOaep", "Aes256Sha256RsaPss"] = (
        "Basic256Sha256"
    )
    """The security policy."""
    mode: Literal["sign", "sign_and_encrypt"] = "sign_and_encrypt"
    """Whether messages are also encrypted."""
    certificate: str
    """File of Rigrunner's certificate, PEM or DER, in the station's folder."""
    private_key: str
    """File of the key that belongs to it."""
    server_certificate: str
    """File of the server's certificate, the only one that is trusted."""


class User(Settings):
    """The user of the login."""

    name: str
    """The user's name."""
    password_file: str
    """File that holds the password; the station itself is kept in every run file."""


class NodeValue(Settings):
    """A node, and what its value is like."""

    node: NodeId
    """Identifier of the node."""
    type: Type | None = None
    """Its type, which must be that of the server; if omitted, that of the server is used."""
    stale: PositiveDuration | None = None
    """Greatest age of its source timestamp; if omitted, its age is not checked."""


class Write(Settings):
    """A number that is written to a node."""

    node: NodeId
    """Identifier of the node."""
    value: Annotated[float, Field(strict=False)]
    """The number to write; 0 or 1 if the node is a Boolean."""
    wait: Annotated[Duration, Field(ge=0)] = 0.0
    """Waiting time before the next one."""


class IdentityNodes(Settings):
    """Nodes with the identity of the instrument, and the expected values."""

    maker: NodeId | None = None
    """Node of the maker; if omitted, the manufacturer of the server."""
    model: NodeId | None = None
    """Node of the model; if omitted, the product name of the server."""
    serial: NodeId | None = None
    """Node of the serial number; a server itself has none."""
    firmware: NodeId | None = None
    """Node of the firmware version; if omitted, the software version of the server."""
    expect: ExpectedIdentity = Field(default_factory=dict)
    """Expected instrument; a run does not start with another one."""


class OpcUaChannel(NodeValue, DeclaredChannel):
    """A channel, and its node."""


class ReadBack(NodeValue, DeclaredQuantity):
    """The node of the actual value of a drive."""


class OpcUaDrive(NodeValue, DeclaredDrive):
    """A drive, and the node of its set-point."""

    read_back: ReadBack | None = None
    """The node of its actual value; if omitted, that of the set-point is read."""
    run: ListOf[Write] = ()
    """Written after a set-point, such as an enable."""
    stop: ListOf[Write] = ()
    """Written before the safe value."""

    @model_validator(mode="after")
    def _can_be_driven(self) -> Self:
        if self.read_back is not None and self.read_back.si_unit != self.si_unit:
            raise ValueError(f"read_back is in {self.read_back.unit}, the drive in {self.unit}")
        if self.type is not None:
            self.fits(self.type)
        return self

    def fits(self, type_: Type) -> None:
        """Raise ValueError unless limits and tolerance can be held in a node of that type."""
        for name in ("min", "max", "safe"):
            try:
                encode(self.from_si(getattr(self, name).si), type_)
            except ValueError as error:
                raise ValueError(f"{name} is {getattr(self, name)}: {error}") from error
        info = self.info("drive")
        step_si = abs(self.to_si(step(type_)) - self.to_si(0.0))
        if type_ != "Boolean" and step_si / 2 > info.allowed_deviation:
            raise ValueError(
                f"a node of type {type_} has steps of {step_si:g} {info.unit}, too coarse for the"
                f" tolerance of {info.allowed_deviation:g} {info.unit}"
            )


class OpcUaSettings(Settings):
    """Nodes of an OPC UA server."""

    endpoint: Annotated[
        str, AfterValidator(_endpoint), WithJsonSchema({"type": "string", "pattern": _ENDPOINT})
    ]
    """Address of the server, such as opc.tcp://192.168.1.30:4840."""
    timeout: PositiveDuration = 2.0
    """Time limit of an answer."""
    security: Security | None = None
    """Security; if omitted, the channel is neither signed nor encrypted."""
    user: User | None = None
    """Login; if omitted, there is none."""
    identification: IdentityNodes = Field(default_factory=IdentityNodes)
    """The expected server."""
    check_units: YesNo = True
    """Whether the EngineeringUnits of a node, if it has any, must be the unit stated here."""
    channels: dict[QuantityName, OpcUaChannel] = Field(default_factory=dict)
    """The channels."""
    drives: dict[QuantityName, OpcUaDrive] = Field(default_factory=dict)
    """The drives, in the order of making safe."""

    def physical_addresses(self) -> tuple[str, ...]:
        """Return where the server listens: one run at a time may drive what is behind it."""
        parts = urlsplit(self.endpoint)
        return (f"tcp:{parts.hostname}:{parts.port or _PORT}",)

    @model_validator(mode="after")
    def _is_complete(self) -> Self:
        if not self.channels and not self.drives:
            raise ValueError("there are neither channels nor drives, expected at least one")
        return self
