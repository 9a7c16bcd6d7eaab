"""Instruments that talk Modbus, over TCP or a serial line, described wholly in the station."""
