"""Robots that are not there: each module runs the written touch program of one controller against a displaced part."""
