"""Where two edges meet: corners, wall ends, fillets, merged and dropped sides."""
