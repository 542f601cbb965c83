"""The torch: its shape and shipped ones, its attitude on a seam, its bodies for a cell, its picture."""
