"""Requests to simulators and their answers: records, programs and files."""
