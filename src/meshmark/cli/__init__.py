"""The command `meshmark`: one file per command, each of which parses, calls and prints.

What is slow to import a command imports after it has read its input: what is wrong with that is reported at once.
"""
