"""Keys, keyed pseudo-random functions, the message and its error-correcting code; no meshes in here."""
