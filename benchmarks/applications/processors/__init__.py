"""How far results differ between processors."""
