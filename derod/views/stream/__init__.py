"""See it in rerun: a push while it runs (``RerunStream``), and run and branch files replayed.

rerun is imported by the process that talks to a viewer, never by the push.
"""
