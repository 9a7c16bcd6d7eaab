"""Reports on many runs: control charts, capability, gauge studies."""
