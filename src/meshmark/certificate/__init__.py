"""The certificate of a marked model."""
