"""What a run leaves: results as files, the baseline, pages and figures."""
