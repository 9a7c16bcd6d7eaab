"""A run on disk: journal, finished recordings, sealed HDF5 file."""

from rigrunner.runfile.folder import create_run_folder
from rigrunner.runfile.lock import is_in_progress, run_lock
from rigrunner.runfile.loose import NEVER_ENDED
from rigrunner.runfile.model import RunHeader, RunInfo, StoredRun
from rigrunner.runfile.parts import end_of, zero_counts
from rigrunner.runfile.probe import refuse_crashing
from rigrunner.runfile.reading import (
    check_file,
    file_differences,
    read,
    read_info,
    read_truth,
    read_with_truth,
    read_without_samples,
    sealed_file_of,
)
from rigrunner.runfile.salvage import DamagedRun, read_damaged, write_salvaged
from rigrunner.runfile.sealing import seal
from rigrunner.runfile.summary import RunSummary, read_summary
from rigrunner.runfile.writer import RunWriter

__all__ = [
    "NEVER_ENDED",
    "DamagedRun",
    "RunHeader",
    "RunInfo",
    "RunSummary",
    "RunWriter",
    "StoredRun",
    "check_file",
    "create_run_folder",
    "end_of",
    "file_differences",
    "is_in_progress",
    "read",
    "read_damaged",
    "read_info",
    "read_summary",
    "read_truth",
    "read_with_truth",
    "read_without_samples",
    "refuse_crashing",
    "run_lock",
    "seal",
    "sealed_file_of",
    "write_salvaged",
    "zero_counts",
]
