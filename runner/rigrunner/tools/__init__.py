"""Tools of a laboratory: make, check, import and compare files, and operate a rig manually."""
