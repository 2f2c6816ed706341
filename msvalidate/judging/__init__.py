"""What was observed, how it is judged, and how a study is run."""
