"""Watermarking schemes; so far one, `ncdg_lv`."""
