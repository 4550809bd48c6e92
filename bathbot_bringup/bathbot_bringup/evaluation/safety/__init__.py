"""The fault matrix: what is made to fail, when, and how the arm's reaction is measured."""
