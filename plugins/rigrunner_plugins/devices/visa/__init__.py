"""Instruments that speak SCPI or another text protocol, described entirely in the station."""
