"""Figures: what each shows as data, and one function for each kind of plot."""
