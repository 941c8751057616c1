"""The command `meshmark`: one file per command, each of which parses, calls and prints."""
