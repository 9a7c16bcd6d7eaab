"""The archive: an index of many run files, to search and to export; the files stay the truth.

From Python: `rigrunner.archive.query("points", specimen="SN-*").to_pandas()`.
"""

from rigrunner.archive.indexing import Indexed, index, rebuild
from rigrunner.archive.querying import open_archive, query
from rigrunner.archive.rows import Rows

__all__ = ["Indexed", "Rows", "index", "open_archive", "query", "rebuild"]
