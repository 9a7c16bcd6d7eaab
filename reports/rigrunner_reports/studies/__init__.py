"""Reports on many runs: control charts, capabilities, gauge studies."""
