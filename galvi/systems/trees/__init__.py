"""Parts of trees of rigid bodies."""
