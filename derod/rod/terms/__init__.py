"""The terms of the energy, one a file."""
