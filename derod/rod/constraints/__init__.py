"""The constraints of the rod, one a file."""
