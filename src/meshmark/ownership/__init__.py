"""The ownership layer: an id that survives damage, embedded and read blind."""
