"""What do numbers say of a model? Prediction, noise, transforms and priors, least squares, evidence; knows no friction."""
