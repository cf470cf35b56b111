"""The templates of every page: one frame, one file for each part."""
