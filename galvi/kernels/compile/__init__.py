"""How kernels are compiled, cached on disk and called by address."""
