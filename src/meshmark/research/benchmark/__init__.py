"""The benchmark: schemes x models x attacks -> rows -> tables and plots."""
