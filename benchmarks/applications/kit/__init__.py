"""Reference solutions and models as data, for projects that do not install galvi."""
