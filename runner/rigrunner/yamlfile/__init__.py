"""Strict YAML that knows where everything stands."""
