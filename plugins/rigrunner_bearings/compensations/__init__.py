"""Ways to subtract the no-load torque of the rig from the measured torque."""
