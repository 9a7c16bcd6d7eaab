"""The state that every screen shows, section by section."""
