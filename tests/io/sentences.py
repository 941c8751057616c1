"""What the message of every refusal has in common."""

from __future__ import annotations


def check_sentence(message: str) -> None:
    """Assert that there is one, on one line."""
    assert message
    assert "\n" not in message
