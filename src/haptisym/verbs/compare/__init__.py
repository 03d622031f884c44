"""Several devices side by side: how far each is transparent, and which one is noticed first."""
