"""Tables of the report: their contents, and their output as CSV, Markdown and LaTeX."""
