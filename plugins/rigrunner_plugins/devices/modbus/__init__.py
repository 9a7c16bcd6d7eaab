"""Instruments that speak Modbus, over TCP or a serial line, described entirely in the station."""
