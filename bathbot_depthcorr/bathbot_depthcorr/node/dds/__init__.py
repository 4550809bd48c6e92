"""How the processes of the graph exchange messages."""
