"""Documents on a run: certificates issued and verified, and packed runs."""
