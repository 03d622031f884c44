"""An evaluation as one page, as a PDF, and in notebooks."""
