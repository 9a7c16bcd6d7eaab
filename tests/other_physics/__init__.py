"""A swing tester with other physics than the shipped simulators, to judge methods and checks.

It is written from its equations alone (see `model`). Methods and thresholds are chosen on even
seeds and judged on odd ones.
"""
