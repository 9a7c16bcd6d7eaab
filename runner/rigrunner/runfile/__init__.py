"""A run on disk: journal, finished recordings, sealed HDF5 file."""

from rigrunner.runfile.folder import create_run_folder
from rigrunner.runfile.model import RunHeader, RunInfo, StoredRun, SweepPlot
from rigrunner.runfile.reading import read, read_info, read_truth
from rigrunner.runfile.sealing import seal
from rigrunner.runfile.writer import RunWriter

__all__ = [
    "RunHeader",
    "RunInfo",
    "RunWriter",
    "StoredRun",
    "SweepPlot",
    "create_run_folder",
    "read",
    "read_info",
    "read_truth",
    "seal",
]
