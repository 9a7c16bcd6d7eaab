"""The operator panel: a browser interface to the engine."""
