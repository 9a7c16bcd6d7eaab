"""The commands for laboratories that test bearings, with their help lines."""

COMMANDS = {
    "Run": {"demo": "Run two procedures on the simulated rig and write the report."},
    "Results": {
        "support-friction": "Compute the friction that the load adds to a rig's support.",
    },
    "Develop": {"study": "Validate uncertainty coverage and fault detection by simulation."},
}
