"""The station of the loopback instruments, for a machine that does other work as well."""

from __future__ import annotations


def patient_station(text: str) -> str:
    """Return the station with longer waits for answers and lines."""
    for termination, patience in (("LF", "timeout: 9 s"), ("CRLF", "stale: 9 s")):
        line = f"            termination: {termination}\n"
        assert text.count(line) == 1
        text = text.replace(line, f"{line}            {patience}\n")
    return text
