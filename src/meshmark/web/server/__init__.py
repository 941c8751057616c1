"""`meshmark serve`: an HTTP server with a page on which models are marked and checked."""
