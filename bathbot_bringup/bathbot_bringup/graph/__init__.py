"""The graph as processes: nodes, isolation, a client, stages."""
