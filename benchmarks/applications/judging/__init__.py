"""The error of a model's own run, and the integrators and steps that reach an error."""
