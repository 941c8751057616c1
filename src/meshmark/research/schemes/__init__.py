"""Watermarking schemes: one interface, our own and the rivals behind it, and the table of them."""
