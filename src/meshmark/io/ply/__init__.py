"""PLY, as text and in both binary byte orders."""
