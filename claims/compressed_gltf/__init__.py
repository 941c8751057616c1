"""Marks in compressed copies of public glTF models, and what broken compressed streams do to the reader."""
