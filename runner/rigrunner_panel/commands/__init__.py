"""The panel's commands with their help lines; a module is imported when called."""

COMMANDS = {
    "Run": {
        "panel": "Open the operator panel in a browser.",
    },
}
