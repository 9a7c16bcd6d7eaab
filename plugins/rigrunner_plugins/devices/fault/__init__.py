"""Any other device with faults injected into its answers and streams."""
