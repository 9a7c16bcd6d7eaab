"""Numbers in registers, their addresses, and the requests that read them."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from rigrunner.api.errors import DeviceRejectedError
from rigrunner_plugins.devices.modbus.grouping import Span, spans
from rigrunner_plugins.devices.modbus.places import Number, Place, Table

# IEEE 754: -118.625 is C2ED4000 hex; 1.0 as binary64 is 3FF0000000000000 hex
KNOWN = [
    ("uint16", "big", "big", [0xFFFF], 65535.0),
    ("int16", "big", "big", [0xFFFF], -1.0),
    ("int16", "big", "little", [0xFEFF], -2.0),
    ("uint32", "big", "big", [0x0001, 0x0002], 65538.0),
    ("uint32", "little", "big", [0x0002, 0x0001], 65538.0),
    ("int32", "big", "big", [0xFFFF, 0xFFFE], -2.0),
    ("float32", "big", "big", [0xC2ED, 0x4000], -118.625),
    ("float32", "little", "big", [0x4000, 0xC2ED], -118.625),
    ("float32", "big", "little", [0xEDC2, 0x0040], -118.625),
    ("float32", "little", "little", [0x0040, 0xEDC2], -118.625),
    ("float64", "big", "big", [0x3FF0, 0, 0, 0], 1.0),
    ("float64", "little", "big", [0, 0, 0, 0x3FF0], 1.0),
]


def stored(type_, word_order, byte_order):
    """Return the register of a number of that type."""
    return Number(holding=0, type=type_, word_order=word_order, byte_order=byte_order)


@pytest.mark.parametrize(("type_", "word_order", "byte_order", "registers", "number"), KNOWN)
def test_numbers_of_known_registers(type_, word_order, byte_order, registers, number):
    assert stored(type_, word_order, byte_order).decode(registers) == number
    assert stored(type_, word_order, byte_order).encode(number) == registers


ORDERS = st.sampled_from(["big", "little"])
RANGES = {
    "int16": (-(2**15), 2**15 - 1),
    "uint16": (0, 2**16 - 1),
    "int32": (-(2**31), 2**31 - 1),
    "uint32": (0, 2**32 - 1),
}


@given(st.sampled_from(sorted(RANGES)), ORDERS, ORDERS, st.data())
def test_integers_survive_encoding(type_, word_order, byte_order, data):
    number = data.draw(st.integers(*RANGES[type_]))
    registers = stored(type_, word_order, byte_order).encode(float(number))
    assert all(0 <= word <= 0xFFFF for word in registers)
    assert stored(type_, word_order, byte_order).decode(registers) == number


@given(st.floats(allow_nan=False, allow_infinity=False, width=32), ORDERS, ORDERS)
def test_floats_survive_encoding(number, word_order, byte_order):
    for type_ in ("float32", "float64"):
        registers = stored(type_, word_order, byte_order).encode(number)
        assert stored(type_, word_order, byte_order).decode(registers) == number


@given(st.sampled_from(sorted(RANGES)), st.floats(allow_nan=True, allow_infinity=True))
def test_number_out_of_range_is_refused_and_never_wrapped(type_, number):
    low, high = RANGES[type_]
    if low - 0.5 < number < high + 0.5:
        registers = stored(type_, "big", "big").encode(number)
        assert abs(stored(type_, "big", "big").decode(registers) - number) <= 0.5
    elif not low - 0.5 <= number <= high + 0.5:
        with pytest.raises(ValueError, match="does not fit"):
            stored(type_, "big", "big").encode(number)


def test_float_that_is_too_large_is_refused():
    with pytest.raises(ValueError, match="does not fit into float32"):
        stored("float32", "big", "big").encode(1e39)


def test_registers_without_a_finite_number_are_refused():
    with pytest.raises(DeviceRejectedError, match="7fc0 0000, no finite float32"):
        stored("float32", "big", "big").decode([0x7FC0, 0x0000])


@pytest.mark.parametrize(
    ("settings", "table", "address"),
    [
        ({"holding": 2}, Table.HOLDING, 2),
        ({"input": "0x2103"}, Table.INPUT, 8451),
        ({"reference": 40003}, Table.HOLDING, 2),
        ({"reference": 400003}, Table.HOLDING, 2),
        ({"reference": 465536}, Table.HOLDING, 65535),
        ({"reference": 30001}, Table.INPUT, 0),
        ({"reference": 10001}, Table.DISCRETE, 0),
        ({"coil": 0}, Table.COIL, 0),
    ],
)
def test_table_and_address_of_a_number(settings, table, address):
    place = Place.model_validate(settings)
    assert (place.table, place.address) == (table, address)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({}, "expected one of holding, input, coil, discrete and reference, got none"),
        ({"holding": 1, "input": 1}, "got holding and input"),
        ({"reference": 40000}, "counted from 1"),
        ({"reference": 3}, "counted from 1"),
        ({"reference": 20001}, "counted from 1"),
        ({"reference": 465537}, "counted from 1"),
        ({"holding": 65536}, "less than or equal to 65535"),
        ({"coil": 1, "type": "int16"}, "a coil is one bit"),
        ({"input": 1, "type": "int16", "bit": 3}, "type and bit are given"),
        ({"input": 65535, "type": "int32"}, "2 registers from 65535 end beyond 65535"),
    ],
)
def test_invalid_places_are_refused(settings, message):
    with pytest.raises(ValidationError, match=message):
        Number.model_validate(settings)


def test_bit_is_counted_from_the_lowest():
    # 0102 hex = 0000 0001 0000 0010: bits 8 and 1
    bits = [Number(input=0, bit=bit).decode([0x0102]) for bit in range(16)]
    assert [bit for bit in range(16) if bits[bit]] == [1, 8]
    assert Number(input=0, bit=0, byte_order="little").decode([0x0102]) == 1.0  # 0201 hex


def numbers(*places):
    return [Number.model_validate(place) for place in places]


def test_only_neighbours_are_read_together():
    places_ = numbers(
        {"input": 4}, {"input": 0, "type": "float32"}, {"input": 2}, {"holding": 3}, {"coil": 9}
    )
    assert spans(places_, together=True) == [
        Span(Table.COIL, 9, 1),
        Span(Table.HOLDING, 3, 1),
        Span(Table.INPUT, 0, 3),
        Span(Table.INPUT, 4, 1),
    ]


def test_each_unit_has_its_own_requests():
    places_ = numbers({"input": 0}, {"input": 1, "unit_id": 2}, {"input": 1}, {"input": 2})
    assert spans(places_, together=True) == [
        Span(Table.INPUT, 0, 3),
        Span(Table.INPUT, 1, 1, unit_id=2),
    ]


def test_number_within_a_longer_one_is_read_with_it():
    places_ = numbers({"input": 0, "type": "float64"}, {"input": 1}, {"input": 4})
    assert spans(places_, together=True) == [Span(Table.INPUT, 0, 5)]


@pytest.mark.parametrize(("table", "most"), [("input", 125), ("coil", 2000)])
def test_more_registers_than_a_request_allows_take_two(table, most):
    places_ = numbers(*({table: address} for address in range(most + 1)))
    assert [span.count for span in spans(places_, together=True)] == [most, 1]


def test_numbers_are_read_one_by_one_if_the_unit_requires_it():
    places_ = numbers({"input": 0, "bit": 1}, {"input": 0, "bit": 2}, {"input": 1})
    assert spans(places_, together=False) == [Span(Table.INPUT, 0, 1), Span(Table.INPUT, 1, 1)]


PLACES = st.builds(
    lambda table, address, type_: {table: address} | ({"type": type_} if type_ else {}),
    st.sampled_from(["holding", "input"]),
    st.integers(0, 300),
    st.sampled_from([None, "float32", "float64"]),
)


@given(st.lists(PLACES, min_size=1, max_size=40), st.booleans())
def test_each_number_is_in_one_request_of_permitted_length(places, together):
    numbers_ = numbers(*places)
    requests = spans(numbers_, together=together)
    assert all(any(span.holds(number) for span in requests) for number in numbers_)
    assert all(span.count <= 125 for span in requests)
    read_addresses = {(span.table, address) for span in requests for address in _addresses(span)}
    assert read_addresses == {
        (number.table, address) for number in numbers_ for address in _addresses(number)
    }


def _addresses(span):
    return range(span.address, span.address + span.count)
