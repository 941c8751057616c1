"""A small multilayer perceptron and its Levenberg-Marquardt training; pure arrays, no meshes."""
