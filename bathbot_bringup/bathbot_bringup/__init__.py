"""The whole bathing assistant: simulated bathroom, recording, replay, reports, commands."""
