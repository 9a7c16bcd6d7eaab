"""`python -m rigrunner_bearings.loopback`: the instruments of a swing tester, on this machine."""

from __future__ import annotations

import signal
import threading
from pathlib import Path

import click


@click.command()
@click.option(
    "--station",
    type=click.Path(dir_okay=False, path_type=Path),
    default=Path("loopback.yaml"),
    show_default=True,
    help="Where the station that binds the instruments is written.",
)
@click.option("--seed", type=click.IntRange(0), default=1, show_default=True, help="Names the rig.")
@click.option("--bridge-port", type=click.IntRange(0, 65535), default=0, help="0: any free one.")
@click.option("--modbus-port", type=click.IntRange(0, 65535), default=0, help="0: any free one.")
def main(station: Path, seed: int, bridge_port: int, modbus_port: int) -> None:
    """Run a torque bridge, an inverter, a press and a load cell on loopback, until Ctrl-C."""
    stop = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: stop.set())
    try:
        _run(station, seed, (bridge_port, modbus_port), stop)
    except OSError as error:
        raise click.ClickException(str(error)) from error


def _run(station: Path, seed: int, ports: tuple[int, int], stop: threading.Event) -> None:
    try:
        from rigrunner_bearings.loopback.bench import running_bench  # noqa: PLC0415  (not on Windows)
    except ImportError as error:
        raise click.ClickException(
            f"the load cell needs a pseudo-terminal, which Linux and macOS have: {error}"
        ) from error
    with running_bench(seed, *ports) as bench:
        station.write_text(bench.station(), encoding="utf-8")
        click.echo(f"torque bridge  SCPI over TCP, 127.0.0.1:{bench.bridge_port}")
        click.echo(f"inverter       Modbus TCP, unit 1 at 127.0.0.1:{bench.modbus_port}")
        click.echo(f"press          Modbus TCP, unit 2 at 127.0.0.1:{bench.modbus_port}")
        click.echo(f"load cell      serial line {bench.cell_port}")
        click.echo(f"station        {station}")
        stop.wait()


if __name__ == "__main__":
    main()
