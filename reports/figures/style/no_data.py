"""Why there is no picture."""


class NoData(Exception):
    """The frame has no finite number for what a figure shows; the message says which."""
