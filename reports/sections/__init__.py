"""The studies of the report: what each says, how it is tabled and drawn; one file each."""
