"""The process that controls the rig, and its jobs: preflight, run and manual session."""
