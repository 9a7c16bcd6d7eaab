"""The commands of the conformance kit, with their line of help: imported when called."""

COMMANDS = {
    "Develop": {
        "check-plugin": "Run the conformance checks on a plugin.",
    },
}
