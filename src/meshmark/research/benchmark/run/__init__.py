"""The engine: suites, jobs, worker processes, and the store of results."""
