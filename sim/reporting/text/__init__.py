"""Words and rows of the page: the sentence of the outcome, tables, labels and sources."""
