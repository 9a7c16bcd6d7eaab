"""Benchmarks: `python -m tests.benchmarks` prints ours, the floor and the peers side by side.

A benchmark is a module of this folder with two functions, made of what `frame` gives:

    def measure(scale: Scale) -> list[Figure]   # timed, for the tables; quick when scale.short
    def work() -> list[Work]                    # counted, for the test that CI runs

and a docstring that says what is measured and what each row means. Programs of other projects run
in their own environment (the extra `peers`; none under the GPL), as scripts under `peers/` that
print a JSON list of numbers last: `frame.peer` makes their row. accuracy, alignment, panel,
panel_screen and tamper are older: scripts that print the tables of other pages.
"""
