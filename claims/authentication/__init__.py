"""The bars of the authentication layer, recovery and unmarking, measured through the public interface."""
