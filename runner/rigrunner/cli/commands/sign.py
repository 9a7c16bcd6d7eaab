"""`rigrunner sign`: sign certificates with the laboratory's key."""

from __future__ import annotations

import os
from pathlib import Path

import click

from rigrunner.api.errors import UsageError
from rigrunner.cli.options import lab_option
from rigrunner.cli.ordering import letterhead_option
from rigrunner.cli.output import message, result

PASSPHRASE = "RIGRUNNER_PASSPHRASE"  # noqa: S105  (the name of a variable)


@click.command(name="sign")
@click.argument("certificate", required=False, type=click.Path(path_type=Path))
@click.option("--key", type=click.Path(path_type=Path), help="The private key to sign with.")
@click.option("--by", metavar="NAME", default="", help="Who signs.")
@click.option(
    "--new-key",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Create a key instead; its public part is FILE.pub.",
)
@click.option(
    "--passphrase",
    "protected",
    is_flag=True,
    help=f"The key has a passphrase, from a prompt or {PASSPHRASE}.",
)
@letterhead_option
@lab_option
def command(
    *,
    certificate: Path | None,
    key: Path | None,
    by: str,
    new_key: Path | None,
    protected: bool,
    letterhead: Path,
    station: str | None,
) -> None:
    """Sign a certificate with the laboratory's key, or create a key.

    One signature covers JSON, HTML and PDF; it is written beside them. Before signing, each page is
    regenerated from its content and compared, and checked against the record of numbers.
    """
    if new_key is not None:
        if certificate is not None or key is not None:
            raise UsageError("--new-key creates a key and signs nothing", hint="do one at a time")
        from rigrunner.proof import keys

        public = keys.new_key(new_key, _passphrase(new=True) if protected else "")
        message(f"Wrote {new_key}: keep it secret, and keep a copy. {public} is for everyone.")
        if not protected:
            message("The key has no passphrase: anyone who can read the file can sign with it.")
        result(keys.fingerprint(keys.read_public_keys(public)[0]))
        return
    if certificate is None or key is None or not by.strip():
        raise UsageError(
            "signing needs a certificate, a key and a name",
            hint="rigrunner sign CERTIFICATE --key FILE --by NAME; --new-key FILE makes a key",
        )
    from rigrunner.clock import WallClock
    from rigrunner.documents.certifying.sign import Signer, sign
    from rigrunner.run.lab_plugins import lab_registry

    if os.name == "nt":
        message("Who may read the key is not checked on Windows: see its Properties, Security.")
    passphrase = _passphrase(new=False) if protected else ""
    signer = Signer(key=key, by=by.strip(), letterhead=letterhead, passphrase=passphrase)
    result(str(sign(certificate, signer, lab_registry(station), WallClock().utc())))


def _passphrase(*, new: bool) -> str:
    if passphrase := os.environ.get(PASSPHRASE):
        return passphrase
    return str(click.prompt("Passphrase", hide_input=True, err=True, confirmation_prompt=new))
