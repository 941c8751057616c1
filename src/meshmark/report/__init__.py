"""Pictures of models: a small software renderer and what the commands draw with it."""
