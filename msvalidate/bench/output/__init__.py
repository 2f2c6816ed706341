"""Results of a run: files, baseline, pages and figures."""
