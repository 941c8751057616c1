"""Commands that measure what the documentation claims: `python -m claims.NAME`."""
