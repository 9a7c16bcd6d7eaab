"""Numbers as the screen's own code formats them."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from pathlib import Path

import pytest

import rigrunner_panel

FORMAT = Path(rigrunner_panel.__file__).parent / "static/js/format.js"


WITH_NODE = pytest.mark.skipif(
    shutil.which("node") is None and os.environ.get("RIGRUNNER_REQUIRE_BROWSER") != "1",
    reason="there is no Node.js",
)


@WITH_NODE
def test_set_value_is_shown_as_written(tmp_path):
    program = """
      import { plain } from './format.mjs';
      const values = [16.5, 35, 0.25, 0, -2.5, 1000, 1 / 3, null, NaN];
      console.log(JSON.stringify(values.map(plain)));
    """
    assert _run_node(tmp_path, program) == [
        *("16.5", "35", "0.25", "0", "\N{MINUS SIGN}2.5", "1000", "0.333333"),
        *("\N{EN DASH}", "\N{EN DASH}"),
    ]


@WITH_NODE
def test_german_screen_shows_and_accepts_a_decimal_comma(tmp_path):
    program = """
      import * as format from './format.mjs';
      const { fixed, shownNumber, typedNumber, useDecimalSign, withUncertainty } = format;
      const typed = ['22,5 °C', '-0,25 N', '22.5 °C', '1,2,3', 'a,5', '24'];
      const english = typed.map(typedNumber);
      useDecimalSign(',');
      console.log(JSON.stringify([
        english, typed.map(typedNumber),
        [fixed(0.7268, 4), withUncertainty(0.7268, 0.0087, 'N·m'),
         shownNumber('1.5 to 2.25 kN, 3 A')],
      ]));
    """
    assert _run_node(tmp_path, program) == [
        ["22,5 °C", "-0,25 N", "22.5 °C", "1,2,3", "a,5", "24"],
        ["22.5 °C", "-0.25 N", "22.5 °C", "1.2,3", "a,5", "24"],
        ["0,7268", "0,7268 ± 0,0087 N·m", "1,5 to 2,25 kN, 3 A"],
    ]


@WITH_NODE
def test_german_list_has_decimal_commas_only_in_number_columns(tmp_path):
    program = """
      import { typedList, useDecimalSign } from './format.mjs';
      const measured = new Set(['room', 'load']);
      const lists = [
        'specimen;room;lot\\r\\nB-1;22,5 °C;L 1,2\\r\\nB-2;-0,25 °C;L 3\\r\\n',
        '\\n Specimen \\t ROOM \\nB,3\\t"22,5 °C"',
        'specimen;room\\nB-4;1,2,3',
        'specimen,room\\nB-5,22.5',
        'B-6,5\\nB-7;22,5',
        '',
      ];
      const english = lists.map((list) => typedList(list, measured));
      useDecimalSign(',');
      console.log(JSON.stringify([lists.map((list) => typedList(list, measured)), english, lists]));
    """
    german, english, lists = _run_node(tmp_path, program)
    assert (
        german
        == [
            "specimen;room;lot\r\nB-1;22.5 °C;L 1,2\r\nB-2;-0.25 °C;L 3\r\n",
            "\n Specimen \t ROOM \nB,3\t22.5 °C",
            "specimen;room\nB-4;1.2,3",  # no number: the server refuses it
            *lists[3:],
        ]
    )
    assert [english[0], *english[2:]] == [lists[0], *lists[2:]]


def _run_node(folder, program):
    shutil.copy(FORMAT, folder / "format.mjs")
    process = subprocess.run(
        ["node", "--input-type=module", "-e", program],
        cwd=folder, capture_output=True, text=True, check=True, timeout=60,
    )  # fmt: skip
    return json.loads(process.stdout)


@WITH_NODE
@pytest.mark.parametrize(
    ("value", "uncertainty", "text"),
    [
        (0.7268, 0.0087, "0.7268 ± 0.0087 A"),
        (3.21e-9, 2.5e-10, "0.00000000321 ± 0.00000000025 A"),  # was 0.000000 ± 0.000000
        (98765.4, 1234, "98800 ± 1200 A"),
        (0.12345, 0.0996, "0.12 ± 0.10 A"),
        (-0.001, 0.1, "0.00 ± 0.10 A"),
        (5.25e-6, None, "0.00000525 A"),  # was 0.000
    ],
)
def test_value_is_rounded_to_two_digits_of_its_uncertainty(tmp_path, value, uncertainty, text):
    literal = "NaN" if uncertainty is None else repr(uncertainty)
    program = f"""
      import {{ withUncertainty }} from './format.mjs';
      console.log(JSON.stringify(withUncertainty({value!r}, {literal}, 'A')));
    """
    assert _run_node(tmp_path, program) == text
