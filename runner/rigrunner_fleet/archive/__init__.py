"""The archive: an index of many run files, to search and to export. The files remain the source.

From Python: `rigrunner_fleet.archive.query("points", specimen="SN-*").to_pandas()`.
"""

from rigrunner_fleet.archive.indexing import Indexed, index, rebuild
from rigrunner_fleet.archive.querying import open_archive, query
from rigrunner_fleet.archive.rows import Rows

__all__ = ["Indexed", "Rows", "index", "open_archive", "query", "rebuild"]
