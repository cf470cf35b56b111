"""The measurements: claims of the papers, work-precision studies, other studies and timings."""
