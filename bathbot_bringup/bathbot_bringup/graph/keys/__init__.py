"""Keys of SROS2: who may join the graph over a network, and what each may hear and say there."""
