"""What simulators are asked and what they answer: requests, programs, files."""
