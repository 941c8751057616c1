"""Research: schemes and rivals, ablation, training and the benchmark; the product never imports it."""
