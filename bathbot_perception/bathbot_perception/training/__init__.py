"""Training of the skin detector in plain torch; needs no ROS (extra `train`)."""

import os

# Threads of torch that spin while they wait starve the thread that makes batches, and anything
# else on a small machine: a step then takes ten times as long. Read when libgomp is loaded.
os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")
# One network on canvases of three shapes, with one or two threads, needs more than the usual 1024.
os.environ.setdefault("ONEDNN_PRIMITIVE_CACHE_CAPACITY", "8192")
