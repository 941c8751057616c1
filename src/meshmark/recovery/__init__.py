"""Recovery: a miniature of the model, and how altered parts return to it (docs/design.md, section 8)."""

from __future__ import annotations
