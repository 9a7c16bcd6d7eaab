"""A station used without a procedure's steps: its devices asked, set and read, points recorded."""
