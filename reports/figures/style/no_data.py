"""The exception of a figure without data."""


class NoData(Exception):
    """The frame has no finite number for what a figure shows; the message says which."""
