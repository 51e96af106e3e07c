"""Scenes drawn from boxes, and what must hold in a push of any of them."""
