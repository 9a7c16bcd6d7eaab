"""Keys of their own that documents have for two partner runs. It imports nothing."""

KEYS = {"no_load": "no_load_run", "no_load_after": "no_load_run_after"}
"""Partner runs that `result/1` and certificates state under a key of their own, as 0.1.0 did: that
version knew no others. A later format has none."""
ONLY, ONLY_AFTER = KEYS
