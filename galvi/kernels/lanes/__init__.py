"""Steps in vector instructions: point masses and rigid bodies, eight stages at a time."""
