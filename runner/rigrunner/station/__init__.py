"""The station: devices, rig description and instrument register."""
