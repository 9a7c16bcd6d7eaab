"""`rigrunner panel`: starts the operator panel."""

from __future__ import annotations

from pathlib import Path, PurePath
from typing import TYPE_CHECKING

import click

from rigrunner.cli.options import runs_option

if TYPE_CHECKING:
    from rigrunner.api.errors import ExitCode


@click.command(name="panel")
@runs_option
@click.option(
    "--procedures",
    type=click.Path(path_type=Path, file_okay=False, exists=True),
    default=Path(),
    show_default=True,
    help="The lab folder with the procedures and stations to choose from.",
)
@click.option(
    "--station",
    "stations",
    multiple=True,
    metavar="NAME",
    help="A station to serve, as seen from the lab folder; by default all.",
)
@click.option(
    "--letterhead",
    type=click.Path(path_type=Path, file_okay=False),
    default=Path("letterhead"),
    show_default=True,
    help="The laboratory's folder for certificates.",
)
@click.option(
    "--signing-key",
    type=click.Path(path_type=Path, dir_okay=False, exists=True),
    help="The laboratory's private key, to sign certificates.",
)
@click.option(
    "--port",
    type=click.IntRange(0, 65535),
    default=8750,
    show_default=True,
    help="The port to listen on; 0 uses a free one.",
)
@click.option(
    "--host",
    default="127.0.0.1",
    show_default=True,
    help="The address to listen on; beyond this machine only with a token.",
)
@click.option(
    "--token",
    envvar="RIGRUNNER_PANEL_TOKEN",
    default="",
    metavar="TEXT",
    help="The token that clients need; better set in RIGRUNNER_PANEL_TOKEN.",
)
@click.option(
    "--public-name",
    default="",
    metavar="HOST",
    help="The public name at a proxy with TLS, with its port unless that is 443.",
)
@click.option("--no-browser", is_flag=True, help="Do not open a browser.")
def command(
    *,
    runs: Path,
    procedures: Path,
    stations: tuple[str, ...],
    letterhead: Path,
    signing_key: Path | None,
    port: int,
    host: str,
    token: str,
    public_name: str,
    no_browser: bool,
) -> ExitCode:
    """Open the operator panel in a browser.

    A run does not depend on the browser. Ctrl-C ends the panel and aborts a run in progress; a
    second one stops it at once. The rig is made safe first.
    """
    from rigrunner.cli.output import message

    try:
        import starlette  # noqa: F401  (only whether it is there)
        import uvicorn  # noqa: F401  (likewise)
        import websockets  # noqa: F401  (likewise)
    except ImportError as error:
        from rigrunner.api.errors import MissingPackageError

        hint = "pip install 'rigrunner[panel]'"
        raise MissingPackageError(f"the panel needs {error.name}", hint=hint) from error
    from rigrunner_panel.serve import serve
    from rigrunner_panel.web.panel import Settings

    settings = Settings(
        runs=runs,
        procedures=procedures,
        stations=tuple(PurePath(name).as_posix() for name in stations),
        letterhead=letterhead,
        signing_key=signing_key,
        host=host,
        token=token,
        public_name=public_name,
    )
    return serve(settings, port, message, open_browser=not no_browser)
