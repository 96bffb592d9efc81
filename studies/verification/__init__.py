"""Verification: known cases of the field, each against a closed form or a published value."""
