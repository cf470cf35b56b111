"""Recommends a method and a step for a required accuracy."""
