"""One module per command, named like it; each is imported when its command is called."""
