"""The sections of the report, one study per file: text, table and figures."""
