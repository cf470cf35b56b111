"""Steps of canonical systems on vector spaces: Nystrom methods, by Newton or fixed point."""
