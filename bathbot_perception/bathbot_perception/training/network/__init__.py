"""The network: layers, anchors, loss, checkpoints."""
