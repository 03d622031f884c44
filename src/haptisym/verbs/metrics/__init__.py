"""The field's measures of transparency beside the JND verdict."""
