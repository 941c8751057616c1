"""Carriers of code bits: lattice cells, their barycentre statistic, and its quantisation."""
