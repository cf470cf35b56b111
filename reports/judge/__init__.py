"""A judgement of a user's model, as sentences, a page and JSON."""
