"""The figures of torque as data, each with its numbers as text."""
