"""The bathing job, step by step."""
