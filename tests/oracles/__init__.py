"""Slow, obvious, written independently of what they check."""
