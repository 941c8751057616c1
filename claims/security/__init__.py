"""Attacks by people who know all the source and not the key: `python -m claims.security NAME`."""
