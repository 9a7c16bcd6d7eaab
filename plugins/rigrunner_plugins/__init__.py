"""The built-in plugins; they are found through entry points like any other plugin."""
