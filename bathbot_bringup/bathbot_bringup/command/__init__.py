"""The `bathbot` command: one file a verb."""
