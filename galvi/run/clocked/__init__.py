"""Runs in a clock: constant steps in tau, dt = g(q) dtau."""
