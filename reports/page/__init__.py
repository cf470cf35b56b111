"""The report as pages: a file for each part, or one self-contained file."""
