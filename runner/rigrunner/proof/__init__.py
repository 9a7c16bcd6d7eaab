"""What shows that documents and numbers follow from one another: comparing, sealing, signing."""
