"""Statistics of the samples of a recording that have limits."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rigrunner.api.errors import DataError
from rigrunner.signal.sample_statistics import SampleStatistics

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from rigrunner.api.data import Array


class RecordedStatistics:
    """Calculates named statistics from the blocks of a recording."""

    def __init__(self, names: Sequence[str]) -> None:
        """Take statistics as 'role.name.statistic'; without any there is no work."""
        self._names = [(name, *name.rpartition(".")[::2]) for name in names]
        self._by_channel = {channel: SampleStatistics() for _, channel, _ in self._names}

    def take(self, channels: Mapping[str, Array]) -> None:
        """Add a block of samples by channel, 'role.name'."""
        for channel, statistics in self._by_channel.items():
            statistics.take(channels[channel])

    def by_name(self) -> dict[str, float]:
        """Return the statistics by name; raise DataError without samples."""
        try:
            values = {name: channel.by_name() for name, channel in self._by_channel.items()}
        except ValueError as error:
            raise DataError(f"{', '.join(self._by_channel)}: {error}") from error
        return {name: values[channel][statistic] for name, channel, statistic in self._names}
