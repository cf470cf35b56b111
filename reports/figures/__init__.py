"""Figures: a catalogue of figures as data, and one drawing function per kind of plot."""
