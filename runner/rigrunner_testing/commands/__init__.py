"""The commands of the conformance kit, with their help lines: imported when called."""

COMMANDS = {
    "Develop": {
        "check-plugin": "Run the conformance checks on a plugin.",
    },
}
