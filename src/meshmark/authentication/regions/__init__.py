"""Verdicts per region."""
