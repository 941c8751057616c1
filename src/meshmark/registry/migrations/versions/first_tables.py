"""Revision 0001: originals and copies."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

__all__ = ["down_revision", "downgrade", "revision", "upgrade"]

revision = "0001"
down_revision = None


def upgrade() -> None:
    """Make the tables."""
    op.create_table(
        "originals",
        sa.Column("row", sa.Integer, primary_key=True),
        sa.Column("digest", sa.String(64), nullable=False, unique=True),
        sa.Column("name", sa.Text, nullable=False),
        sa.Column("points", sa.Integer, nullable=False),
        sa.Column("registered_at", sa.String(20), nullable=False),
        sa.Column("descriptor", sa.LargeBinary),
    )
    op.create_table(
        "copies",
        sa.Column("row", sa.Integer, primary_key=True),
        sa.Column("id", sa.String(16), nullable=False),
        sa.Column("key", sa.String(16), nullable=False),
        sa.Column("original_row", sa.Integer, sa.ForeignKey("originals.row"), nullable=False),
        sa.Column("recipient", sa.Text),
        sa.Column("path", sa.Text),
        sa.Column("state", sa.String(8), nullable=False),
        sa.Column("strength", sa.String(16)),
        sa.Column("layers", sa.String(16)),
        sa.Column("carriers", sa.String(8)),
        sa.Column("lattice", sa.String(32)),
        sa.Column("spacing", sa.Float),
        sa.Column("step", sa.Float),
        sa.Column("mark_format", sa.Integer),
        sa.Column("meshmark", sa.String(32)),
        sa.Column("issued_at", sa.String(20)),
        sa.Column("marked_digest", sa.String(64)),
        sa.Column("commitment", sa.String(64)),
        sa.Column("certificate", sa.Text),
        sa.UniqueConstraint("id", "key", name="one_copy_for_each_id"),
    )
    op.create_index("copies_of_an_original", "copies", ["original_row", "key"])
    op.create_index("copies_of_a_recipient", "copies", ["recipient"])


def downgrade() -> None:
    """Remove them, with all that they hold."""
    op.drop_table("copies")
    op.drop_table("originals")
