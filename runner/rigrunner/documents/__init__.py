"""Documents on runs: certificates issued and verified, and packed runs."""
