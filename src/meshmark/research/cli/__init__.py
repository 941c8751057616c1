"""The commands that the research wheel adds."""
