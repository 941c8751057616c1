"""Registration of a reference to a suspect."""
