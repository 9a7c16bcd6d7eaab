"""What people write, as JSON Schema for their editors and in words."""
