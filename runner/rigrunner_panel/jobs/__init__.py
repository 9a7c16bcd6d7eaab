"""The program of the process that has the rig, and its jobs: preflight, run, manual session."""
