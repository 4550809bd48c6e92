"""The graph as processes: the nodes there are, a graph of our own while it runs, and its client."""
