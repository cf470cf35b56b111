"""What is measured: claims of the papers, work-precision studies, costs and timings."""
