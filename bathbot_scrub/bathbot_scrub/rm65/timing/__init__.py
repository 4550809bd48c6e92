"""A steady beat: schedule, priority, and how regular it was."""
