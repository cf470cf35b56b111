"""External forces that references recognise by type and fields."""
