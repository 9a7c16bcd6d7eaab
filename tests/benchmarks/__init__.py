"""Benchmarks: `python -m tests.benchmarks` compares ours with the floor and the peers.

A benchmark is a module of this folder with two functions, made with `frame`:

    def measure(scale: Scale) -> list[Figure]   # timed, for the tables; quick when scale.short
    def work() -> list[Work]                    # counted, for the test that CI runs

and a docstring that states what is measured and the meaning of each row. Programs of other projects
run in their own environment (the extra `peers`; none under the GPL), as scripts under `peers/` that
print a JSON list of numbers last: `frame.peer` makes their row. accuracy, alignment, panel,
panel_screen and tamper are scripts that print the tables of other pages.
"""
