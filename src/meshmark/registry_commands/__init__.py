"""The commands of the registry, `meshmark registry` and `meshmark trace`: parse, call, print. Part of its wheel."""
