"""Scenes with copies: each mesh once, however often it is shown."""
