"""The procedure language: models and loading."""
