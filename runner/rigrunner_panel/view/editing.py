"""Who edits which procedure: a section of the state of all screens."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict


class EditorView(BaseModel):
    """A screen on which a procedure is being edited."""

    model_config = ConfigDict(frozen=True)

    client: str
    """The short name of the screen, to compare with `you`."""
    name: str
    """The name of the person; '' if it is not known."""
    since_utc: str


class EditedView(BaseModel):
    """A procedure that somebody edits."""

    model_config = ConfigDict(frozen=True)

    procedure: str
    """Its name in the list."""
    digest: str
    """Digest of its file now; it differs from that of the opened text if the file was changed."""
    changed_utc: str
    changed_by: str
    """Who saved it at the panel; '' if another program changed it."""
    approved_utc: str
    """When its approvals were last written; '' for none."""
    editors: tuple[EditorView, ...]
