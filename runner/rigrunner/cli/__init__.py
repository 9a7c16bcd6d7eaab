"""The command line. It and the panel are the only layers that show errors to people."""
