"""How one kind of figure is drawn."""
