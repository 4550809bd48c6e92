"""The simulated bathroom: body, camera with the D455 error model, and the RM65 controller."""
