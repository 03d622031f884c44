"""A scene's formulas as a product: in steps, solved, dimensionless, with leading terms."""
