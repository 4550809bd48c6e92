"""One scrub of a region: what it is planned from, the thread that runs it, and how it ends."""
