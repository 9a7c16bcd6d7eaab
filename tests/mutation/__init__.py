"""Mutation tests: `python -m tests.mutation` lists changes of the sources that no test detects.

`mutants` makes small changes in the sources, `record` records which tests run which lines, and
`trial` runs the tests of a changed line in a separate process. `equivalent.toml` lists the
mutants that no test can detect, each with the reason.
"""
