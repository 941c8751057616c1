"""Search strategies: where in a suspect the mark may be read."""
