"""For each answer the page that says it."""
