"""What simulated testers have in common: sensors with their errors, and the device around a rig.

Nothing here knows of friction or of a drive line; those belong to each simulated rig alone.
"""
