"""From and to other packages, which are imported when a door is used and never before."""
