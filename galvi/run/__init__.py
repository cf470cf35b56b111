"""Integration: from a problem and a method to a trajectory."""
