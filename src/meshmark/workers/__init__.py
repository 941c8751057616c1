"""Processes that work for this one, under limits of time and memory."""
