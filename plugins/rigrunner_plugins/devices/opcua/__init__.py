"""Nodes of an OPC UA server, described entirely in the station."""
