"""What the report shows of torque: its sections, figures and templates."""
