"""A file for the HDF5 library whose writes never fail; it reports errors afterwards.

HDF5 does not survive a failed write: it keeps the half-closed file and crashes the process when it
releases it. So it must not see a full disk. Data that cannot be written are dropped, the first
error is kept, and the file, which is temporary, is not used.
"""

from __future__ import annotations

import io
import os
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pathlib import Path


class PatientFile(io.RawIOBase):
    """A new binary file, opened for writing and reading; `error` is its first error."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self._file = path.open("w+b", buffering=0)
        self._position = 0
        self._size = 0
        self.error: OSError | None = None

    def close(self) -> None:
        """Close the file; idempotent."""
        self._file.close()
        super().close()

    def readable(self) -> bool:
        """Return True: HDF5 reads back what it wrote."""
        return True

    def writable(self) -> bool:
        """Return True."""
        return True

    def seekable(self) -> bool:
        """Return True."""
        return True

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        """Move to a position, and return it."""
        start = {os.SEEK_SET: 0, os.SEEK_CUR: self._position, os.SEEK_END: self._size}
        self._position = start[whence] + offset
        return self._position

    def tell(self) -> int:
        """Return the position."""
        return self._position

    def readinto(self, buffer: Any) -> int:
        """Fill the buffer; with zeros if the data could not be written."""
        view = memoryview(buffer).cast("B")
        view[:] = bytes(len(view))
        if self.error is None:
            self._file.seek(self._position)
            self._file.readinto(view)
        self._position += len(view)
        return len(view)

    def write(self, data: Any) -> int:
        """Write all data, or keep the error and drop them."""
        remaining = memoryview(data).cast("B")
        size = len(remaining)
        if self.error is None:
            try:
                self._file.seek(self._position)
                while remaining:
                    remaining = remaining[self._file.write(remaining) :]
            except OSError as error:
                self.error = error
        self._position += size
        self._size = max(self._size, self._position)
        return size

    def truncate(self, size: int | None = None) -> int:
        """Set the size of the file, or keep the error."""
        self._size = self._position if size is None else size
        if self.error is None:
            try:
                self._file.truncate(self._size)
            except OSError as error:
                self.error = error
        return self._size
