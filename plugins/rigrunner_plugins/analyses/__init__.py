"""The analyses of any quantity that ship."""
