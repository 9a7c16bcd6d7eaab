"""The guardian: a small process that makes the rig safe when the process of a run dies or hangs."""
