"""Calls with arguments at random: what must never happen, whatever is given."""
