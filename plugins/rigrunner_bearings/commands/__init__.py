"""The commands for laboratories that test bearings, with their help lines."""

COMMANDS = {
    "Run": {"demo": "Run both procedures on the simulated rig and write the report."},
    "Results": {
        "support-friction": "State what the load adds to the friction of a rig's support.",
    },
    "Develop": {"study": "Validate uncertainty coverage and fault detection by simulation."},
}
