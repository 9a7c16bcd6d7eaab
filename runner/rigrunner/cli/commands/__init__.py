"""One module for each command, with its name; it is imported when the command is called."""
