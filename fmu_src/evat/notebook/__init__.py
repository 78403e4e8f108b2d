"""What does a notebook want of a result? Datasets with units, figures, tables in HTML: of plain columns, whatever they came from."""
