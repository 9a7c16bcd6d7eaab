"""The operator panel: a client of the engine, on a screen."""
