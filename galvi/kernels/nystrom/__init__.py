"""A step of a canonical system on a vector space: a Nystrom tableau, Newton or fixed point."""
