"""What a simulator must do right before any number of it counts."""
