"""Use a station without a procedure: query its devices, set drives, read and record points."""
