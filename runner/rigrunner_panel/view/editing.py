"""Who edits which procedure, as it goes to every screen."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict


class EditorView(BaseModel):
    """A screen on which a procedure is being edited."""

    model_config = ConfigDict(frozen=True)

    client: str
    """Its short name, to compare with `you`."""
    name: str
    since_utc: str


class EditedView(BaseModel):
    """A procedure that somebody edits."""

    model_config = ConfigDict(frozen=True)

    procedure: str
    """Its name in the list."""
    digest: str
    """Of its file now: another one than that which was opened means that it was changed."""
    changed_utc: str
    changed_by: str
    """Who saved it at the panel; '' where it was changed by another program."""
    editors: tuple[EditorView, ...]
