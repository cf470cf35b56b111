"""Which releases of an engine change a user's run, and the bound of a regression test of it."""
