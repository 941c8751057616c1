"""Makes the hare that `meshmark demo` marks; `python tools/make_demo_model.py` runs it."""
