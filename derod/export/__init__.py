"""Runs and branches for other programs: CSV tables, and VTK files for ParaView."""
