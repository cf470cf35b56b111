"""What was computed for a report: claims, comparisons, studies, and their cache."""
