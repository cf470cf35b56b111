"""Steps of point masses in a clock, in vector instructions."""
