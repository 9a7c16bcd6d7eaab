"""The state that every screen shows, and how events change it."""
