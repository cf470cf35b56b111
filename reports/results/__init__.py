"""The results of a report: claims, comparisons and studies, and their cache."""
