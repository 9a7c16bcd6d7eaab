"""The torque in the report: its sections, figures and templates."""
