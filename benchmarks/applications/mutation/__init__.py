"""How many small faults, planted in the sources one at a time, the tests find."""
