"""Runs a plan on a rig, emits events, always makes safe."""
