"""Makes a client of asyncua and connects it: channel, certificates, user."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from asyncua import Client, ua
from asyncua.crypto import security_policies, uacrypto
from cryptography import x509

from rigrunner.api import DeviceNotFoundError, DeviceRejectedError, DeviceTimeoutError

if TYPE_CHECKING:
    from pathlib import Path

    from rigrunner_plugins.devices.opcua.settings import OpcUaSettings, Security

_MODES = {
    "sign": ua.MessageSecurityMode.Sign,
    "sign_and_encrypt": ua.MessageSecurityMode.SignAndEncrypt,
}


async def open_client(settings: OpcUaSettings, folder: Path) -> Client:
    """Return a connected client; raise a DeviceError."""
    client = Client(settings.endpoint, timeout=settings.timeout)
    client.name = client.description = "Rigrunner"
    if settings.user is not None:
        client.set_user(settings.user.name)
        client.set_password(_text(_inside(folder, settings.user.password_file)))
    if settings.security is not None:
        await _secure(client, settings.security, folder)
    try:
        await client.connect()
    except TimeoutError as error:
        raise DeviceTimeoutError(
            f"{settings.endpoint} does not answer within {settings.timeout:g} s",
            hint="is the server running, and is it an OPC UA server (opc.tcp)?",
        ) from error
    except OSError as error:
        # In the system's own words: asyncio puts addresses in their place.
        reason = os.strerror(error.errno) if error.errno and error.errno > 0 else str(error)
        raise DeviceNotFoundError(
            f"{settings.endpoint} cannot be reached: {reason}",
            hint="is the server running, are host and port correct, and does it use opc.tcp?",
        ) from error
    except ua.UaError as error:
        raise DeviceRejectedError(
            f"{settings.endpoint} refuses the connection: {error_text(error)}",
            hint="see `user` and `security`, and whether the server trusts our certificate",
        ) from error
    return client


def error_text(error: Exception) -> str:
    """Return the message of an OPC UA error, with the name of its status code."""
    if isinstance(error, ua.UaStatusCodeError):
        return status(error.code)
    return str(error) or type(error).__name__


def status(code: int) -> str:
    """Return the name of a status code, and its meaning."""
    name, meaning = ua.status_codes.get_name_and_doc(code)
    return f"{name} ({meaning.rstrip('.')})"


async def _secure(client: Client, security: Security, folder: Path) -> None:
    certificate_path = _inside(folder, security.certificate)
    key_path = _inside(folder, security.private_key)
    server_path = _inside(folder, security.server_certificate)
    try:
        certificate = await uacrypto.load_certificate(certificate_path)
        client.application_uri = _application_uri(certificate) or client.application_uri
        await client.set_security(
            getattr(security_policies, f"SecurityPolicy{security.policy}"),
            certificate_path,
            key_path,
            server_certificate=str(server_path),
            mode=_MODES[security.mode],
        )
    except OSError as error:
        raise DeviceRejectedError(
            f"{error.filename} cannot be read: {error.strerror}",
            hint="files of `security` must be in the station's folder",
        ) from error
    except (ValueError, TypeError, ua.UaError) as error:
        raise DeviceRejectedError(
            f"the certificates of `security` cannot be used: {error_text(error)}",
            hint="expected X.509 certificates and a private key without a password, PEM or DER",
        ) from error


def _application_uri(certificate: x509.Certificate) -> str:
    """Return the URI of the certificate's holder, which a server compares with the client's."""
    try:
        names = certificate.extensions.get_extension_for_class(x509.SubjectAlternativeName)
    except x509.ExtensionNotFound:
        return ""
    return next(iter(names.value.get_values_for_type(x509.UniformResourceIdentifier)), "")


def _inside(folder: Path, name: str) -> Path:
    """Return a file beside the station: no other is handed to a server that a station names."""
    path = (folder / name).resolve()
    if not path.is_relative_to(folder.resolve()):
        raise DeviceRejectedError(
            f"{name} is outside the station's folder", hint=f"put it into {folder.resolve()}"
        )
    return path


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8").rstrip("\r\n")
    except (OSError, UnicodeDecodeError) as error:
        raise DeviceRejectedError(
            f"the password file {path} cannot be read: {error}",
            hint="put it into the station's folder",
        ) from error
