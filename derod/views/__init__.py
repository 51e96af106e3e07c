"""What one looks at: plots, rerun streams, exports."""
