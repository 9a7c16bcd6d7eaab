"""The composition root: prepare, record, analyse, report."""
