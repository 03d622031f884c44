"""The field's measures of transparency compared with the JND verdict."""
