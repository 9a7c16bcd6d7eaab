"""One role from several instruments."""
