"""The teach sheet: a part in four views with the reference points to touch, and a table to fill in by hand."""

from cad.sheet.make import SHEET_SUFFIXES, Sheet, SheetOptions, make_sheet
from cad.sheet.paper import Paper

__all__ = ["SHEET_SUFFIXES", "Paper", "Sheet", "SheetOptions", "make_sheet"]
