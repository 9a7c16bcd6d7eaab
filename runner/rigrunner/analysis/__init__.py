"""From recordings to a result: pure functions, no I/O, no clock."""
