"""Text files of numbers: words, lines, number styles, and positions patched in place."""
