"""`rigrunner support-friction`: what the load adds to the friction of a rig's support."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from rigrunner.cli.options import json_option, lab_option, run_argument, runs_option
from rigrunner.cli.output import result, result_json
from rigrunner.run.locate import find_run

if TYPE_CHECKING:
    from pathlib import Path


@click.command(name="support-friction")
@run_argument
@runs_option
@lab_option
@json_option
def command(run: str, runs: Path, station: str | None, *, as_json: bool) -> None:
    """Compute the friction that the load adds to a rig's support.

    RUN is a run of the procedure support_friction with a bearing of known friction. The lines for
    the station are printed; later results use them.
    """
    from rigrunner.run.lab_plugins import lab_registry
    from rigrunner.signal.coverage import expanded
    from rigrunner.signal.rounding import with_uncertainty
    from rigrunner_bearings.known_bearing import support_friction

    friction = support_friction(find_run(run, runs), lab_registry(station))
    if as_json:
        result_json(friction.document())
        return
    torque, growth = friction.torque, friction.growth
    in_torque = with_uncertainty(1000 * torque.value, 1000 * expanded(torque))
    in_share = with_uncertainty(100 * growth.value, 100 * expanded(growth))
    result(
        f"{friction.load_n:.6g} N adds ({in_torque}) mN·m to the support's friction where the"
        f" starting torque is read,\n({in_share}) % of its dry friction there (95 %)."
        f" In the station:\n\n{friction.lines}"
    )
