"""A swing tester of other physics than the simulators that ship, for judging methods and checks.

It is written from its equations alone (see `model`). Methods and thresholds are chosen on even
seeds and judged on odd ones.
"""
