"""Instruments that talk SCPI or other ASCII, described wholly in the station file."""
