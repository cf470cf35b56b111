"""Pinocchio's dynamics of trees of rigid bodies."""
