"""How wrong is a model's own run, and which integrator and step reach an error."""
