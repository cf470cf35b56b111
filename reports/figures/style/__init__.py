"""Colours, markers, axes and labels that all figures share."""
