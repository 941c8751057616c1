"""Training of the networks that the product ships."""
