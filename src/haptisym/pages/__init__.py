"""For each answer the document that says it: ``page(answer)``, in a module named as the verb."""
