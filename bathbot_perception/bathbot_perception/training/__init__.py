"""Training of the skin detector in plain torch; needs no ROS (extra `train`)."""

import os

# Threads that spin while they wait starve the rest of a small machine. Read when libgomp is loaded.
os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")
# A network on canvases of three shapes needs more compiled layers than the usual 1024.
os.environ.setdefault("ONEDNN_PRIMITIVE_CACHE_CAPACITY", "8192")
