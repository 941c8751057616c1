"""The tables and figures of the NCDG-LV paper: what it claims, beside what is measured here."""
