"""Bytes of OPC UA as printed in its specification.

OPC 10000-6 (OPC UA Part 6: Mappings), clause 5.2.2: the examples of each type. They check the
library against the standard for what stations use: node ids, and the values of nodes.
"""

from __future__ import annotations

import pytest
from asyncua import ua
from asyncua.common.utils import Buffer
from asyncua.ua.ua_binary import (
    nodeid_from_binary,
    nodeid_to_binary,
    pack_uatype,
    unpack_uatype,
)


@pytest.mark.parametrize(
    ("written", "encoded"),
    [
        ("i=72", "00 48"),  # figure 'A Two Byte NodeId'
        ("ns=5;i=1025", "01 05 01 04"),  # figure 'A Four Byte NodeId'
        # figure 'A String NodeId'
        ("ns=1;s=Hot\N{CJK UNIFIED IDEOGRAPH-6C34}", "03 01 00 06 00 00 00 48 6F 74 E6 B0 B4"),
    ],
)
def test_encoding_of_node_ids(written, encoded):
    node = ua.NodeId.from_string(written)
    assert nodeid_from_binary(Buffer(bytes.fromhex(encoded))) == node
    if node.NodeIdType is ua.NodeIdType.String:  # numbers may also be written in a longer form
        assert nodeid_to_binary(node) == bytes.fromhex(encoded)


@pytest.mark.parametrize(
    ("type_", "value", "encoded"),
    [
        (ua.VariantType.Int32, 1_000_000_000, "00 CA 9A 3B"),  # clause 5.2.2.2, figure
        (ua.VariantType.Float, -6.5, "00 00 D0 C0"),  # clause 5.2.2.3, figure
    ],
)
def test_encoding_of_numbers(type_, value, encoded):
    assert pack_uatype(type_, value) == bytes.fromhex(encoded)
    assert unpack_uatype(type_, Buffer(bytes.fromhex(encoded))) == value
