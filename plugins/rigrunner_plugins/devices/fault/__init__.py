"""Any other device with faults put into what it answers and streams."""
