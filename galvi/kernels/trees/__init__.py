"""Trees of rigid bodies on joints, by recursion."""
