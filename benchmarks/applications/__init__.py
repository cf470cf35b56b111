"""Beside the report: a user's models and integrators, clouds."""
