"""Studies of what many runs found: from an archive to charts, capabilities and gauge studies."""
