"""The erasure code of the payload."""
