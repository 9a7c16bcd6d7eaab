"""What a procedure names beside itself: procedures that it calls, pictures that it shows."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from rigrunner.api.errors import InvalidFileError, Problem, RigrunnerError, did_you_mean
from rigrunner.procedure.loading import InconsistentProcedureError, parse_procedure
from rigrunner.procedure.walk import steps_of
from rigrunner.yamlfile.document import dotted
from rigrunner.yamlfile.reader import MAX_BYTES, read_text

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from rigrunner.procedure.kinds import Kinds
    from rigrunner.procedure.loading import LoadedProcedure
    from rigrunner.procedure.references import Values
    from rigrunner.procedure.steps import Step
    from rigrunner.yamlfile.document import Path as DocumentPath


MAX_CALLS = 200
"""At all depths together: two calls in each file double the number with each level."""
MAX_CHARACTERS = MAX_BYTES
"""Of all files together, each counted as often as it is called: a single one may be as long."""


def load_procedure(
    path: Path, kinds: Kinds | None = None, *, text: str | None = None
) -> LoadedProcedure:
    """Return the procedure in that file with those that it calls.

    `kinds` are the kinds of steps and the analyses that it may name; left out, the installed ones.
    `text` is taken for what the file has: of an editor, before it is saved. Raises InvalidFileError
    with all that is wrong, in any of the files.
    """
    return _Loader(kinds).load(path, {}, (), text)


@dataclass(eq=False)
class _Loader:
    """Loads a procedure and what it calls; counts the calls, and what is read for them."""

    kinds: Kinds | None = None
    calls: int = 0
    characters: int = 0

    def load(
        self, path: Path, values: Values, callers: tuple[Path, ...], text: str | None = None
    ) -> LoadedProcedure:
        """Return a procedure that was called by others, the outermost first."""
        contradiction: InconsistentProcedureError | None = None
        text = read_text(path) if text is None else text
        self.characters += len(text)
        try:
            loaded = parse_procedure(text, str(path), values, self.kinds)
        # It is read nevertheless, so that errors in its calls are reported with it.
        except InconsistentProcedureError as error:
            loaded, contradiction = error.loaded, error
        problems: dict[Problem, None] = {}
        called: dict[DocumentPath, LoadedProcedure] = {}
        for at, step in steps_of(loaded.model):
            try:
                _check_picture(step, at, loaded)
                call = step.settings.calls()
                if call is not None:
                    called[at] = self._load_call(*call, (*at, step.kind), loaded, (*callers, path))
            except InvalidFileError as error:
                problems.update(dict.fromkeys(error.problems))
        complete = replace(loaded, called=called)
        if problems:
            raise InvalidFileError((*(contradiction.problems if contradiction else ()), *problems))
        if contradiction:
            raise InconsistentProcedureError(contradiction.problems, complete)
        return complete

    def _load_call(
        self,
        name: str,
        values: Mapping[str, Any],
        at: DocumentPath,
        caller: LoadedProcedure,
        callers: tuple[Path, ...],
    ) -> LoadedProcedure:
        named_at = (*at, "procedure")
        try:
            path = file_beside(caller.folder, name)
        except FileBesideError as error:
            raise _error_at(caller, named_at, error.message, error.hint) from error
        chain = [caller.resolve() for caller in callers]
        if path.resolve() in chain:
            circle = " calls ".join(each.name for each in (*callers, path))
            raise _error_at(caller, named_at, f"a procedure cannot call itself: {circle}")
        self.calls += 1
        if self.calls > MAX_CALLS or self.characters > MAX_CHARACTERS:
            limit = f"{MAX_CALLS} calls, or {MAX_CHARACTERS:,} characters in the called files"
            raise _error_at(caller, named_at, f"more than {limit}")
        places = {key: (caller.document, (*at, "with", key)) for key in values}
        called = self.load(path, places, callers)
        for role, device in called.model.uses.items():
            if caller.model.uses.get(role) != device:
                hint = f"add it here: 'uses: {{{role}: {device}}}'"
                message = f"it uses a {device} in the role '{role}', which this procedure does not"
                raise _error_at(caller, named_at, message, hint)
        return called


def _check_picture(step: Step, at: DocumentPath, loaded: LoadedProcedure) -> None:
    for key, name in step.settings.pictures():
        try:
            picture_beside(loaded.folder, name)
        except FileBesideError as error:
            raise _error_at(loaded, (*at, step.kind, key), error.message, error.hint) from error


def _error_at(
    loaded: LoadedProcedure, at: DocumentPath, message: str, hint: str = ""
) -> InvalidFileError:
    return InvalidFileError([Problem(message, loaded.document.where(at), dotted(at), hint)])


_LONGEST = 80
PICTURES = (".png", ".jpg", ".jpeg", ".svg", ".gif", ".webp")


class FileBesideError(RigrunnerError):
    """A file that is named cannot be had."""


def file_beside(folder: Path, name: str) -> Path:
    """Return the file of that relative name in a folder or below; raise FileBesideError.

    Whatever the name says, nothing outside of the folder is looked at.
    """
    path = folder / name
    # As a name it stays inside also on systems where backslash and colon separate.
    parts = name.replace("\\", "/").split("/")
    is_below = ".." not in parts and bool(parts[0]) and ":" not in name
    try:
        inside = is_below and path.resolve().is_relative_to(folder.resolve())
        is_file = inside and path.is_file()
    except (OSError, RuntimeError) as error:  # a name that is too long, links in a circle
        reason = getattr(error, "strerror", None) or "links lead in a circle"
        raise FileBesideError(f"'{name[:_LONGEST]}' cannot be looked up: {reason}") from error
    if not inside:
        hint = "name a file beside this one, or in a folder below"
        raise FileBesideError(f"'{name[:_LONGEST]}' is outside this file's folder", hint=hint)
    if not is_file:
        names = [file.name for file in path.parent.glob("*")] if path.parent.is_dir() else []
        hint = did_you_mean(path.name, names, f"looked in {path.parent}")
        raise FileBesideError(f"there is no file '{name[:_LONGEST]}'", hint=hint)
    return path


def picture_beside(folder: Path, name: str) -> Path:
    """Return the picture of that relative name; raise FileBesideError."""
    path = file_beside(folder, name)
    if path.suffix.lower() not in PICTURES:
        raise FileBesideError(f"'{name}' is not a picture", hint=f"allowed: {', '.join(PICTURES)}")
    return path
