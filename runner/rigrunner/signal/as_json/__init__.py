"""Numbers, budgets, curves and checks as `result.json` has them."""
