"""A rig that another program drives."""
