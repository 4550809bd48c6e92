"""What stops the arm: the force guard and the watchdogs."""
