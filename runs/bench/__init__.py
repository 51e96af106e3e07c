"""Parts of the speed-against-error studies."""
