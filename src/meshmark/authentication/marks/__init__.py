"""The marks of authentication: which points carry them and what they say."""
