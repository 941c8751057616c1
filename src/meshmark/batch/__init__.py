"""One command for many models: resumable, each model under limits of its own."""
