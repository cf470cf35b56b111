"""Compilation of kernels, their cache on disk, and calls by address."""
