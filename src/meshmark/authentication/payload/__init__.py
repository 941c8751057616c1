"""The payload that the marks carry."""
