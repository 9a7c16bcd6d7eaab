"""The torque of bearings on their testers: the oldest of the analyses."""
