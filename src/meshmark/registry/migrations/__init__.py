"""The migrations of a registry, for alembic; `migrating` runs them."""
