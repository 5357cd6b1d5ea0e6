# Needs Python 3.11 or later and make; everything else goes into .venv.
PYTHON ?= $(shell command -v python3.11 || command -v python3 || command -v python)
BIN := $(if $(filter Windows_NT,$(OS)),.venv/Scripts,.venv/bin)
READY := .venv/.ready
# kept bytecode starts workers and commands several times as fast
unexport PYTHONDONTWRITEBYTECODE

.PHONY: atlas explorer explorer-library basins report notebooks pictures docs docs-opened linkcheck peers \
  test tests test-browser test-outside test-long lint bench derive lock clean

# The main job: the stability diagrams of three bodies, in atlas/index.html.
atlas: $(READY)
	$(BIN)/stability atlas --out atlas --overwrite

# The diagrams alive in a browser, in explorer.html: open it by a double click.
explorer: $(READY)
	$(BIN)/stability explore --out explorer.html --overwrite

# The part of three.js that the explorer needs, bundled from its npm package; needs Node 20 and npm.
explorer-library:
	cd stability/explorer/library && npm ci --no-audit --no-fund && npm run build && rm -r node_modules

# Which launch ends where, near rolling and spinning, for three bodies: stores and figures in
# basins/, with SIZE launches.  What was finished before an interruption is kept.
SIZE ?= 200x160
basins: $(READY)
	@mkdir -p basins
	@for body in disk:0.25 annulus:0.3125 hoop:0.5; do for family in rolling spinning; do \
	  $(BIN)/stability basins --family $$family --k $${body#*:} --mu 0.3 --time 2000 --overwrite \
	    --x at:0.02:3:$(firstword $(subst x, ,$(SIZE))) --y tilt:0.01:1.2:$(lastword $(subst x, ,$(SIZE))) \
	    --out basins/$$family-$${body%:*}.zarr --plot basins/$$family-$${body%:*}.pdf || exit 1; \
	done; done

# Cost against error by every route, and where methods fail, measured on this machine, in
# report/index.html; what was finished before an interruption is kept.
report: $(READY)
	$(BIN)/stability report --out report

# Jupyter with the notebooks; what is saved there goes to NAME.ipynb and NAME.py both.
notebooks: .venv/.jupyter
	$(BIN)/jupyter lab notebooks

# Every notebook run from NAME.py, and kept with its output and pictures as NAME.ipynb; the films of the docs.
pictures: .venv/.jupyter
	$(BIN)/python docs/notebooks.py
	$(BIN)/python docs/films.py
	$(BIN)/python docs/explorer_picture.py

.venv/.jupyter: $(READY)
	$(BIN)/python -m pip install -q --disable-pip-version-check -c constraints.txt -e '.[notebook]'
	@touch $@

# The documentation site in build/site/html: every cell and command run, every figure drawn; a warning is an error.
docs: .venv/.docs
	$(BIN)/python -m sphinx -b html -j 3 -W --keep-going -q docs build/site/html
	$(BIN)/python docs/sphinx_parts/links.py
	@echo "open build/site/html/index.html"

# Every page of the built site in a Chromium, from its file: nothing on the console, no request, no page too wide.
docs-opened: docs
	$(BIN)/python docs/sphinx_parts/opened.py

# Every address on the site, asked over the network.
linkcheck: .venv/.docs
	$(BIN)/python -m sphinx -b linkcheck -j 2 docs build/site/links

.venv/.docs: $(READY)
	$(BIN)/python -m pip install -q --disable-pip-version-check -c constraints.txt -e '.[docs]'
	@touch $@

# Lint, types and tests, in five minutes on two cores. ARGS goes to pytest, here and below.
test: $(READY)
	@$(MAKE) --no-print-directory -j 2 lint tests
	@echo "Not tested here: pages in a browser (make test-browser); LaTeX, C and AUTO (make test-outside); campaigns (make test-long)."

tests: $(READY)
	$(BIN)/pytest -q -n 2 --dist loadscope $(ARGS)

# Pages of the explorer, films and the site's checks in a Chromium of the system.
test-browser: $(READY)
	$(BIN)/pytest -q -m browser tests $(ARGS)

# What other programs make of the exports: pdflatex, a C compiler, gfortran with AUTO-07p.
test-outside: $(READY)
	$(BIN)/pytest -q -m outside tests $(ARGS)

# Campaigns of minutes: thousands of random points against ball arithmetic, large maps.
test-long: $(READY)
	$(BIN)/pytest -q -m "long and not (browser or outside)" $(ARGS)

# The figures that the README quotes, measured here; ARGS=--large adds the large map.
bench: $(READY)
	$(BIN)/python benchmarks/maps.py $(ARGS)
	$(BIN)/python benchmarks/bodies.py
	$(BIN)/python benchmarks/large.py
	$(BIN)/python benchmarks/kernels.py $(ARGS)
	$(BIN)/python benchmarks/motion.py $(ARGS)
	$(BIN)/python benchmarks/scenes.py $(ARGS)
	$(BIN)/python benchmarks/basins.py $(ARGS)
	$(BIN)/python benchmarks/explorer.py

# Other people's codes compared with this one. What is not installed is reported as missing.
peers: $(READY)
	$(BIN)/python -m pip install -q --disable-pip-version-check -c constraints.txt -e '.[peers]'
	for peer in sympy_kane heyoka_raw auto auto_demos mujoco_disk; do \
	  echo; echo "== $$peer"; $(BIN)/python benchmarks/peers/$$peer.py || exit 1; done

# Every polynomial and condition derived again from the graph, into disk_polynomials.json and body_polynomials.json;
# it says which differ from the stored ones.
derive: $(READY)
	PYTHONPATH=notebooks $(BIN)/python -m proofs.stored

lint: $(READY)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/python docs/words.py

# The versions that were tested, for constraints.txt.
lock: $(READY)
	$(BIN)/pip freeze --exclude-editable --exclude pip --exclude setuptools > constraints.txt

$(READY): pyproject.toml constraints.txt
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
	  { echo "Python 3.11 or later is needed; say make PYTHON=/path/to/python3.11"; exit 1; }
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install -q --disable-pip-version-check -c constraints.txt -e '.[test]'
	$(BIN)/python -m compileall -q -j 2 stability
	@touch $@

clean:
	rm -rf docs/_made docs/notebooks docs/reference/*.rst docs/live/explorer.md
	rm -rf .venv atlas basins report build *.egg-info .pytest_cache .mypy_cache .ruff_cache .hypothesis
