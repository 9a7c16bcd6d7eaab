"""`rigrunner archive`: index and search many run folders."""

from __future__ import annotations

from rigrunner.cli.lazy import lazy_group

SUMMARIES = {
    "index": "Bring the archive up to date with folders of runs.",
    "search": "Find runs by specimen, rig, procedure and results.",
    "export": "Write runs or set-points to a CSV or Parquet file.",
    "check": "Read all files, and list what is damaged, missing, changed or unknown.",
    "rebuild": "Rebuild the archive from the run files.",
}

command = lazy_group(
    "archive",
    __name__,
    SUMMARIES,
    """Index many run folders, search them and export their results.

The archive can be rebuilt from the run files at any time.""",
)
