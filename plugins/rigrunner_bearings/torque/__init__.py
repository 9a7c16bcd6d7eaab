"""The analyses of torque: at the reversals of swings, and at starts from rest."""
