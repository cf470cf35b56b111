"""Runs in a frame that moves with an integrable flow."""
