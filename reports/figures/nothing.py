"""Why there is no picture."""


class NothingToDraw(Exception):
    """The frame has no finite number for what a figure shows; the message says which."""
