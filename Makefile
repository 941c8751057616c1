# Every target sets itself up: `make demo` and `make test` work on a fresh machine with Python 3.11+ and make.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
PIP := $(BIN)/python -m pip install --quiet --disable-pip-version-check
export OMP_NUM_THREADS ?= 1

.PHONY: help setup demo test check docs tour gallery site smoke bench clean

help:  ## list the targets
	@grep -hE '^[a-z]+:.*##' $(MAKEFILE_LIST) | sed -E 's/:.*## /: /'

setup: $(VENV)/.stamp  ## make .venv with the package and all tools in it

$(VENV)/.stamp: pyproject.toml registry-wheel/pyproject.toml research-wheel/pyproject.toml web-wheel/pyproject.toml constraints.txt
	@$(PYTHON) -c 'import sys; sys.exit(0 if sys.version_info >= (3, 11) else "meshmark needs Python 3.11 or newer: make PYTHON=python3.12 ...")'
	@test -x $(BIN)/python || $(PYTHON) -m venv $(VENV) || { rm -rf $(VENV); echo "cannot make a virtual environment (on Debian and Ubuntu: apt install python3-venv)"; exit 1; }
	$(PIP) -c constraints.txt uv  # installs the rest in a quarter of pip's time
	@$(BIN)/uv pip install --quiet --python $(BIN)/python -c constraints.txt -e ".[attacks,batch,postgres]" -e ./registry-wheel -e ./research-wheel -e ./web-wheel --group dev || \
	{ echo "uv could not install the packages (it does not read pip's configuration): pip does"; \
	  $(PIP) "pip>=25.1" && $(PIP) -c constraints.txt -e ".[attacks,batch,postgres]" -e ./registry-wheel -e ./research-wheel -e ./web-wheel --group dev; }
	@touch $@

demo: setup  ## the whole way on one model, into demo-out/
	$(BIN)/meshmark demo --out demo-out --force

# Memory that arrays give back is kept for the next ones, which takes 4 % off.
test: export MALLOC_TRIM_THRESHOLD_ = 536870912
test: export MALLOC_MMAP_THRESHOLD_ = 67108864
test: setup  ## all tests, in a process on each core (four at most)
	$(BIN)/python -m pytest -n auto --maxprocesses 4 --dist loadfile --no-loadscope-reorder

check: setup  ## style and types
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

docs: setup  ## write docs/cli.md from the program's own help
	$(BIN)/python tools/make_cli_docs.py

tour: setup  ## write the tour of docs/tour.md and README.md from a run of it
	$(BIN)/python tools/make_tour.py

gallery: setup  ## make the pictures of docs/gallery.md and docs/design.md anew
	$(BIN)/python tools/make_gallery.py
	$(BIN)/python tools/make_design_pictures.py

site: setup  ## a web site of the documents, into site-out/; a link that leads nowhere fails
	@$(BIN)/uv pip install --quiet --python $(BIN)/python -c constraints.txt --group site || \
	{ $(PIP) "pip>=25.1" && $(PIP) -c constraints.txt --group site; }
	$(BIN)/python tools/make_site.py

smoke: setup  ## the smallest benchmark, and the facts that must hold in its table
	rm -rf bench-out/smoke
	$(BIN)/meshmark bench smoke --limit 1 --out bench-out/smoke
	$(BIN)/python tools/check_smoke.py bench-out/smoke/results.csv

bench: setup  ## the measurements; needs ../shared/data
	$(BIN)/python -m claims

clean:  ## remove what the other targets made
	rm -rf $(VENV) demo-out bench-out site-out .pytest_cache .mypy_cache .ruff_cache .hypothesis
