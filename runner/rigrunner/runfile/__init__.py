"""A run on disk: journal, finished recordings, sealed HDF5 file."""

from rigrunner.runfile.folder import create_run_folder
from rigrunner.runfile.manifest import Difference
from rigrunner.runfile.model import RunHeader, RunInfo, StoredRun, SweepPlot
from rigrunner.runfile.probe import refuse_crashing
from rigrunner.runfile.reading import file_differences, read, read_info, read_truth, sealed_file_of
from rigrunner.runfile.sealing import seal
from rigrunner.runfile.writer import RunWriter

__all__ = [
    "Difference",
    "RunHeader",
    "RunInfo",
    "RunWriter",
    "StoredRun",
    "SweepPlot",
    "create_run_folder",
    "file_differences",
    "read",
    "read_info",
    "read_truth",
    "refuse_crashing",
    "seal",
    "sealed_file_of",
]
