"""The HTTP side: access, requests and responses."""
