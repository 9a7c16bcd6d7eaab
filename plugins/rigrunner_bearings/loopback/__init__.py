"""The instruments of a swing tester, served on this machine."""
