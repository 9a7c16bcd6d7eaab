"""What the process that has the rig does."""
