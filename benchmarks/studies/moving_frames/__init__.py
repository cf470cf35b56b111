"""Studies of moving frames: published problems, and stiff springs in long steps."""
