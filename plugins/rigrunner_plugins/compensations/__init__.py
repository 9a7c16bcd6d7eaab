"""Ways to take the rig's part out of the measured torque."""
