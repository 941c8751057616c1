"""Attacks on marked models: one small function each, and the table of them."""
