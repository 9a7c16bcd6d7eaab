"""Instruments with real protocols on loopback, fed by a model of the rig: for trying a station."""
