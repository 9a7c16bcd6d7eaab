"""Mutation tests: `python -m tests.mutation` shows which changed rules no test notices.

`mutants` makes small changes in the sources, `record` finds out which tests run which lines, and
`trial` runs the tests of a changed line in a process of its own. `equivalent.toml` lists the
mutants that no test can find, each with the reason.
"""
