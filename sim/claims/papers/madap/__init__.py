"""MADAP: the accuracies that an approach monitor is asked for."""
