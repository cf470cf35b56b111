"""What the documentation generates: reference, commands, compared integrators, the ledger."""
