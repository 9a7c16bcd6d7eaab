#!/usr/bin/env python3
"""Fits NIST's Statistical Reference Datasets, and counts the digits that agree.

    python docs/evidence/strd_page.py docs/evidence

Writes `strd.md`. The data are in tests/reference/strd, as NIST publishes them
(https://www.itl.nist.gov/div898/strd/).
"""

from __future__ import annotations

import re
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from rigrunner.api.data import Points
from rigrunner.api.errors import DataError
from rigrunner.registry import load_registry

if TYPE_CHECKING:
    from collections.abc import Iterator

FOLDER = Path(__file__).parents[2] / "tests/reference/strd"
REGISTRY = load_registry()
LINEAR: dict[str, tuple[str, dict[str, Any]]] = {
    "Norris": ("polynomial", {"degree": 1}),
    "Pontius": ("polynomial", {"degree": 2}),
    "NoInt1": ("basis", {"powers": [1]}),
    "NoInt2": ("basis", {"powers": [1]}),
    "Filip": ("polynomial", {"degree": 10}),
    "Longley": (
        "expression",
        {
            "over": [f"x{k}" for k in range(1, 7)],
            "start": {f"B{k}": 1 for k in range(7)},
            "model": "B0 + B1*x1 + B2*x2 + B3*x3 + B4*x4 + B5*x5 + B6*x6",
        },
    ),
    "Wampler1": ("polynomial", {"degree": 5}),
    "Wampler2": ("polynomial", {"degree": 5}),
    "Wampler3": ("polynomial", {"degree": 5}),
}
MEANT = {"linear": 15, "nonlinear": 11}
"""Digits that are certified."""
HEAD = """# Digits of the fits

Number of digits of the estimates and their standard deviations that agree with the certified values
of NIST's [Statistical Reference Datasets](https://www.itl.nist.gov/div898/strd/): the log
relative error -log10(|found - certified|/|certified|), the minimum over all parameters. NIST
certifies 15 digits for linear sets and 11 for nonlinear ones; more are not counted. Made by

```sh
python docs/evidence/strd_page.py docs/evidence
```
<!-- run by the test of the digits -->

on a machine whose extended precision has 64 bits of mantissa. Less precision gives fewer digits.
"""
LINEAR_HEAD = """
## Linear

| data set | fit | estimates | standard deviations |
|---|---|---|---|"""
NONLINEAR_HEAD = """
The estimates of Wampler1 and 2 have no standard deviation: the data lie on the curve.

## Nonlinear

The fit is `expression`, with the model of the file, from both starts given by NIST: start
1 is far from the solution, start 2 near. Digits of the estimates / of the standard deviations:

| data set | start 1 | start 2 | model |
|---|---|---|---|"""
END = """
{failed}

The residuals of Lanczos1 are no larger than 10⁻¹³, and double precision rounds its data at 10⁻¹⁶.
This limits the digits of the standard deviations, which come from the residuals.
"""


@dataclass(frozen=True)
class Certified:
    """A file: data, model and certified values; `starts` (2, p) of a nonlinear set."""

    name: str
    model: str
    points: Points
    estimates: np.ndarray
    standard_deviations: np.ndarray
    starts: np.ndarray
    residual_s: float
    r_squared: float


def read(name: str) -> Certified:
    """Return a file of NIST's."""
    text = (FOLDER / f"{name}.dat").read_text()
    start, end = map(int, re.search(r"Data\s+\(lines\s+(\d+)\s+to\s+(\d+)\)", text).groups())
    data = np.array([line.split() for line in text.splitlines()[start - 1 : end]], float)
    y, x = data[:, 0], data[:, 1:]
    rows = re.findall(r"^\s+[bB]\d+(?: =)?((?:\s+[-+.\dEe]+)+)\s*$", text, re.MULTILINE)
    table = np.array([row.split() for row in rows], float)
    model = re.search(r"^\s+(y|log\[y\])\s*=\s*(.*?)\s*\+\s*e\s*$", text, re.MULTILINE | re.DOTALL)
    several = x.shape[1] > 1
    squared = re.search(r"R-Squared\s+(\S+)", text)
    return Certified(
        name=name,
        model=" ".join(model[2].split()).replace("[", "(").replace("]", ")") if model else "",
        points=Points(
            x if several else x[:, 0],
            np.log(y) if model and model[1] == "log[y]" else y,
            x_unit="",
            y_unit="",
            regressors=tuple(f"x{k}" for k in range(1, x.shape[1] + 1)) if several else (),
        ),
        estimates=table[:, -2],
        standard_deviations=table[:, -1],
        starts=table[:, :-2].T,
        residual_s=float(re.search(r"Standard\s+Deviation:?\s+(\d\S+)", text)[1]),
        r_squared=float(squared[1]) if squared else np.nan,
    )


def nonlinear() -> list[str]:
    """Return the names of the nonlinear sets."""
    files = sorted(FOLDER.glob("*.dat"))
    return [each.stem for each in files if "Nonlinear Least Squares" in each.read_text()]


def fitted(nist: Certified, start: int = 0) -> Any:
    """Return the curve of the set, of a nonlinear one from start 1 or 2; raise DataError."""
    name, settings = LINEAR.get(nist.name, ("expression", {}))
    if start:
        values = nist.starts[start - 1]
        settings = {
            "over": list(nist.points.regressors or ("x",)),
            "start": {f"b{k}": float(value) for k, value in enumerate(values, 1)},
            "model": nist.model,
        }
    return REGISTRY.make("fit", name, settings)(nist.points)


def digits(found: Any, certified: Any) -> float:
    """Return the log relative error, the least over all values; log absolute error at zero."""
    found, certified = np.atleast_1d(found), np.atleast_1d(certified)
    error = np.abs(found - certified) / np.where(certified == 0, 1, np.abs(certified))
    return float(-np.log10(np.maximum(error, 1e-16)).min())


def digits_of(nist: Certified, start: int = 0) -> tuple[float, float]:
    """Return the digits of the estimates and of the standard deviations that are certified."""
    curve = fitted(nist, start)
    most = MEANT["nonlinear" if start else "linear"]
    u = np.sqrt(np.diag(curve.covariance))
    pair = digits(curve.coefficients, nist.estimates), digits(u, nist.standard_deviations)
    return min(pair[0], most), min(pair[1], most)


def page() -> str:
    """Return the page."""
    return "\n".join([HEAD.rstrip("\n"), *_lines()])


def _lines() -> Iterator[str]:
    yield LINEAR_HEAD
    for name in LINEAR:
        kind = LINEAR[name][0]
        yield f"| {name} | `{kind}` | {_shown(digits_of(read(name)))} |"
    yield NONLINEAR_HEAD
    failed = []
    for name in nonlinear():
        nist, cells = read(name), []
        for start in (1, 2):
            try:
                cells.append(_shown(digits_of(nist, start), " / "))
            except DataError as error:
                failed.append(f"{name} from start {start}: {error}")
                cells.append("failed")
        yield f"| {name} | {' | '.join(cells)} | `{nist.model}` |"
    yield END.format(failed="Failed: " + "; ".join(failed) if failed else "None fails.")


def _shown(found: tuple[float, float], between: str = " | ") -> str:
    return between.join(f"{each:.1f}" for each in found)


def main() -> None:
    """Write the page into the folder that is named."""
    (folder,) = sys.argv[1:]
    (Path(folder) / "strd.md").write_text(page(), encoding="utf-8")


if __name__ == "__main__":
    main()
