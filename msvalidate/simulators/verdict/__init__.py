"""What is said of a simulator: state, causes, advice, sheet, page and record."""
