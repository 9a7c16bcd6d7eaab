"""`python -m rigrunner_plugins.loopback`: the instruments of a bench, on this machine."""

from __future__ import annotations

import signal
import threading
from pathlib import Path

import click

from rigrunner.api import Imported

BENCHES = {
    "chamber": Imported("rigrunner_plugins.loopback.chamber:running_chamber"),
    "lever": Imported("rigrunner_plugins.loopback.lever:running_lever"),
}


@click.command()
@click.option(
    "--station",
    type=click.Path(dir_okay=False, path_type=Path),
    default=Path("loopback.yaml"),
    show_default=True,
    help="Where the station that binds the instruments is written.",
)
@click.option(
    "--bench",
    "which",
    type=click.Choice(BENCHES),
    default="chamber",
    show_default=True,
    help="A chamber with an ohmmeter, or a lever with a torque transducer.",
)
@click.option("--seed", type=click.IntRange(0), default=1, show_default=True, help="Names the rig.")
def main(station: Path, which: str, seed: int) -> None:
    """Run the instruments of a bench on loopback, until Ctrl-C."""
    over = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: over.set())
    try:
        with BENCHES[which](seed) as bench:
            station.write_text(bench.station(), encoding="utf-8")
            for name, port in bench.ports.items():
                click.echo(f"{name:<15}SCPI over TCP, 127.0.0.1:{port}")
            click.echo(f"{'station':<15}{station}")
            over.wait()
    except OSError as error:
        raise click.ClickException(str(error)) from error


if __name__ == "__main__":
    main()
