"""Claims about vector spaces: V1 to V36."""
