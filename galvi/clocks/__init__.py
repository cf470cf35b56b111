"""Clocks: constant steps in tau, with dt = g(q) dtau."""
