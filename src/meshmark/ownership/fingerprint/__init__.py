"""The fingerprint: the id once more, in many points beside the cells, by which combined copies are traced."""
