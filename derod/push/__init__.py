"""The quasi-static push."""
