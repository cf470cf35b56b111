"""Steps of point masses and rigid bodies in vector instructions, eight stages at a time."""
