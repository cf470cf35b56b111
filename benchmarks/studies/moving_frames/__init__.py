"""Studies of moving frames: stiff springs in long steps."""
