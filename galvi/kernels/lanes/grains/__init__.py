"""Grains in the wind, each in a lane of its own, with contact with the ground."""
