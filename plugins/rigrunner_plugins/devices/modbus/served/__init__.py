"""Simulated instruments that answer Modbus, and the server on loopback that serves them."""
