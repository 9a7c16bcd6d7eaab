"""Nodes of an OPC UA server, described wholly in the station."""
