"""Data acquisition devices of National Instruments, by NI-DAQmx."""
