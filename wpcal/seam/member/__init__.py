"""The members of a part: what each solid is taken for, and which of them are held together by bolts."""
