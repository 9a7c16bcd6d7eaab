"""Propagation of distributions by a Monte Carlo method (JCGM 101:2008), blocked and adaptive."""
