"""What a person or a robot touched: tables, kinds of rows, pairs of points, and points stored in robot programs."""
