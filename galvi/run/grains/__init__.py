"""Many grains in the wind: they start at their own times, and land or rebound."""
