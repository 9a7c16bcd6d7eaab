"""Error responses of the panel."""

from __future__ import annotations

from pydantic import BaseModel

from rigrunner.api.errors import (
    AbortedError,
    DataError,
    DeviceError,
    InvalidFileError,
    Problem,
    RigrunnerError,
    UsageError,
)

_CODES: dict[type[RigrunnerError], str] = {
    InvalidFileError: "invalid",
    DeviceError: "device",
    DataError: "data",
    UsageError: "usage",
    AbortedError: "aborted",
}


class ProblemView(BaseModel):
    """One problem in a file."""

    message: str
    where: str
    field: str
    hint: str


class ErrorView(BaseModel):
    """The body of every error response."""

    code: str
    message: str
    hint: str = ""
    problems: tuple[ProblemView, ...] = ()


class PanelError(Exception):
    """An error response with an HTTP status."""

    def __init__(
        self,
        status: int,
        code: str,
        message: str,
        hint: str = "",
        problems: tuple[Problem, ...] = (),
    ) -> None:
        super().__init__(message)
        self.status = status
        self.view = ErrorView(
            code=code, message=message, hint=hint, problems=tuple(map(_problem, problems))
        )


def panel_error(error: RigrunnerError) -> PanelError:
    """Return the response for an error of the engine."""
    if isinstance(error, InvalidFileError):
        return PanelError(422, "invalid", error.message, error.hint, error.problems)
    where = f"{error.location}: " if error.location else ""
    message = f"{where}{error.message}"
    field = error.field if isinstance(error, UsageError) else ""
    problems = (Problem(message, field=field, hint=error.hint),) if field else ()
    return PanelError(422, error_code(error), message, error.hint, problems)


def error_code(error: RigrunnerError) -> str:
    """Return the code for a kind of error."""
    return next((code for kind, code in _CODES.items() if isinstance(error, kind)), "invalid")


def wrong_state(message: str, hint: str = "") -> PanelError:
    """Return the response for a request that is not possible in the present state."""
    return PanelError(409, "wrong_state", message, hint)


def not_found(message: str, hint: str = "") -> PanelError:
    """Return the response for something that does not exist."""
    return PanelError(404, "not_found", message, hint)


def _problem(problem: Problem) -> ProblemView:
    where = "" if problem.location is None else str(problem.location)
    return ProblemView(message=problem.message, where=where, field=problem.field, hint=problem.hint)
