"""From and to other packages, which are imported when one of these is called and never before."""
