"""The viewer of models: sources in `source`, one bundle that pages hold, its style sheet."""
