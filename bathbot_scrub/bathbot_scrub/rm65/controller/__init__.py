"""The controller's protocol: commands, answers, pushed state, error codes."""
