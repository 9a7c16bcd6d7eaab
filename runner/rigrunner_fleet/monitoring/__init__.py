"""Studies of many runs of an archive: control charts, capability and gauge studies."""
