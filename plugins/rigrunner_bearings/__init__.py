"""Self-lubricating spherical plain bearings: their testers, methods and simulators."""
