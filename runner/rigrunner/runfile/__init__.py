"""A run on disk: journal, finished recordings, sealed HDF5 file."""
