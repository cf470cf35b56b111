"""Point masses: which step fails or errs, and where."""
