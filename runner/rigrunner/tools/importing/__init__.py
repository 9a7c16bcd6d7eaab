"""From recordings that another program made to a run that the same analysis takes."""
