"""The settings of the listeners that ship: when to send, and to where."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated, Literal, Self, get_args

from pydantic import Field, model_validator

from rigrunner.api import ListOf, PlainText, PluginError, PositiveDuration, Settings, YesNo

When = Literal["run_ended", "waits_for_answer", "alarm", "disk_low", "calibration_due"]
EVERY: tuple[When, ...] = get_args(When)
Port = Annotated[int, Field(ge=1, le=65535)]
Address = Annotated[str, Field(pattern=r"^[^@\s<>,;]+@[^@\s<>,;]+$", max_length=254)]


class Secret(Settings):
    """Where a secret is read when a run begins: an environment variable or a file.

    Each run stores the station file, so it must not contain secrets.
    """

    env: Annotated[str, Field(pattern=r"^[A-Za-z_][A-Za-z0-9_]*$")] | None = None
    """The name of the variable."""
    file: Annotated[str, Field(min_length=1)] | None = None
    """The path of the file, absolute or from `~`."""

    @model_validator(mode="after")
    def _one(self) -> Self:
        if (self.env is None) == (self.file is None):
            raise ValueError("write one of 'env' and 'file'")
        if self.file is not None and not Path(self.file).expanduser().is_absolute():
            raise ValueError(f"file: got '{self.file}', expected a path from '/' or '~'")
        return self

    def read(self) -> str:
        """Return the secret without spaces around it; raise PluginError where there is none."""
        if self.env is not None:
            secret, where = os.environ.get(self.env, ""), f"the variable {self.env}"
        else:
            where = f"the file {self.file}"
            try:
                secret = Path(str(self.file)).expanduser().read_text(encoding="utf-8")
            except (OSError, UnicodeDecodeError) as error:
                hint = "write the secret into it, readable for the account that runs tests"
                raise PluginError(
                    f"cannot read {where}: {type(error).__name__}", hint=hint
                ) from error
        if not secret.strip():
            message = f"{where} is empty or not set"
            raise PluginError(message, hint="a listener of the station needs it")
        return secret.strip()


class RuleSettings(Settings):
    """When a message is sent, and how long is tried."""

    on: ListOf[When] = EVERY
    """Reported events."""
    wait: PositiveDuration = 10.0
    """Waiting time for a person after which a question or a pause is reported."""
    disk_low_gb: Annotated[float, Field(gt=0)] = 5.0
    """Free disk space for runs below which it is reported, in 10⁹ bytes."""
    calibration_due_days: Annotated[int, Field(ge=0)] = 14
    """Days before a calibration is due from which it is reported at the start of a run."""
    timeout: PositiveDuration = 5.0
    """Time limit for sending one message."""
    attempts: Annotated[int, Field(ge=1, le=10)] = 5
    """Greatest number of attempts for a message, at intervals of 1 s, 2 s, 4 s, and so on."""


class WebhookSettings(RuleSettings):
    """Settings of the listener `webhook`."""

    url: Annotated[str, Field(pattern=r"^https?://[^\s@/]+(/\S*)?$")]
    """The address that JSON is posted to; redirects are not followed."""
    secret: Secret | None = None
    """The key of the signature; without one the messages are not signed."""


class MailSettings(RuleSettings):
    """Settings of the listener `mail`."""

    host: Annotated[str, Field(min_length=1)]
    """The mail server."""
    port: Port = 587
    """Its port for submission."""
    security: Literal["starttls", "tls", "none"] = "starttls"
    """`none` sends everything unencrypted, including the password."""
    user: PlainText = ""
    """User name; if omitted, there is no login."""
    password: Secret | None = None
    """Password of the user."""
    sender: Address
    """Sender of the mails."""
    to: Annotated[ListOf[Address], Field(min_length=1)]
    """Recipients."""


class MqttSettings(RuleSettings):
    """Settings of the listener `mqtt`."""

    host: Annotated[str, Field(min_length=1)]
    """The broker."""
    port: Port = 1883
    """Its port; 8883 is usual with TLS."""
    tls: YesNo = False
    """Whether the connection is encrypted, and the broker's certificate checked."""
    user: PlainText = ""
    """User name; if omitted, there is no login."""
    password: Secret | None = None
    """Password of the user."""
    topic: Annotated[str, Field(pattern=r"^[^\s#+\x00]+$", max_length=200)] = (
        "rigrunner/{station}/{kind}"
    )
    """Topic; `{station}` and `{kind}` are replaced."""


class AppriseSettings(RuleSettings):
    """Settings of the listener `apprise`."""

    urls: Secret
    """The addresses of its services, one per line: they contain passwords and tokens."""
