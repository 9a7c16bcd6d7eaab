"""The commands of the panel, with their line of help: one module each, imported when called."""

COMMANDS = {
    "Run": {
        "panel": "Open the operator panel in a browser.",
    },
}
