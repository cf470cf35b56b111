"""The figures of the report, as data."""
