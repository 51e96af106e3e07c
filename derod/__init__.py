"""derod: dynamic relaxation of a discrete elastic rod that coils inside a liquid drop."""

__version__ = "0.1.0"
