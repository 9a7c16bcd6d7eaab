"""`rigrunner fit`: fit a curve to the columns of a table."""

from __future__ import annotations

from pathlib import Path

import click

from rigrunner.api.summaries import pairs, table
from rigrunner.cli.options import json_option, lab_option
from rigrunner.cli.output import result, result_json


@click.command(name="fit")
@click.argument("file", type=click.Path(path_type=Path, dir_okay=False, exists=True))
@click.option("--y", required=True, metavar="COLUMN", help="The column to fit.")
@click.option(
    "--x", multiple=True, required=True, metavar="COLUMN", help="The column of x; may be repeated."
)
@click.option("--u", metavar="COLUMN", help="The standard uncertainties of y.")
@click.option(
    "--fit",
    "reference",
    default="polynomial",
    show_default=True,
    metavar="FIT",
    help="The fit as a procedure writes it, such as 'polynomial: {degree: 3}'.",
)
@lab_option
@json_option
def command(
    *,
    file: Path,
    y: str,
    x: tuple[str, ...],
    u: str | None,
    reference: str,
    station: str | None,
    as_json: bool,
) -> None:
    """Fit a curve to columns of a CSV file.

    Its first line names the columns. Several regressors, --x repeated, need the fit 'expression',
    which calls them by the names of their columns. Units are those of the table.
    """
    from rigrunner.run.lab_plugins import lab_registry
    from rigrunner.signal.as_json.curves import curve_of
    from rigrunner.tools.table_fit import fit_of_table

    curve = fit_of_table(file, y=y, x=x, u=u, fit=reference, registry=lab_registry(station))
    if as_json:
        result_json(curve_of(curve))
        return
    rows = [
        [name, f"{value:.15g}", f"{variance**0.5:.6g}", "" if unit == "1" else unit]
        for name, value, variance, unit in zip(
            curve.names, curve.coefficients, curve.covariance.diagonal(), curve.units, strict=True
        )
    ]
    parameters = table(["parameter", "estimate", "standard uncertainty", "unit"], rows, "lrrl")
    goodness = pairs(
        [
            ("degrees of freedom", f"{curve.dof:g}"),
            ("residual standard deviation", f"{curve.residual_s:.6g}"),
            ("R²", f"{curve.r_squared:.6g}"),
        ]
    )
    result(f"{curve.formula}\n\n{parameters}\n\n{goodness}")
