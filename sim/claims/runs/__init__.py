"""The experiments of the papers, on their own models and on flights: what the measures of the ledger are made of."""
