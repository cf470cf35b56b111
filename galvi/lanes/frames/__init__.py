"""Collocation in a frame that moves with an integrable flow, in vector instructions."""
