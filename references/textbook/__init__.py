"""Textbook methods, written independently of galvi."""
