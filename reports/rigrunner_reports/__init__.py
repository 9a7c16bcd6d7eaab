"""From a result to a report that people can read and check."""
