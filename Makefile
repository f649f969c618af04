# Everything a fresh machine needs is python3 (3.10 or 3.11, with venv) and make.
PYTHON ?= $(shell for p in python3 python3.11 python3.10; do \
	$$p -c 'import sys; sys.exit(not (3, 10) <= sys.version_info < (3, 12))' 2>/dev/null && echo $$p && break; done)
BIN := .venv/bin
INSTALLED := .venv/.installed

.PHONY: demo test bench lint ros clean

demo: $(INSTALLED)  ## run experiment real2 with five cameras -> runs/real2/
	$(BIN)/han-bullet run real2 --out runs/real2
	$(BIN)/han-bullet report runs/real2

test: $(INSTALLED)  ## run all tests (arguments for pytest: make test ARGS="-k tracker")
	@.ci/install_mosquitto
	@.ci/install_ros
	$(BIN)/python -m pytest $(ARGS)

bench: $(INSTALLED)-bench  ## run all benchmarks, beside others' packages -> benchmarks/RESULTS.md
	$(BIN)/python -m benchmarks

lint: $(INSTALLED)  ## style and types
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

ros:  ## install ROS 1 and rviz from the system's packages, where it has them (Debian 12, Ubuntu 22.04)
	@.ci/install_ros

$(INSTALLED): setup.py constraints.txt
	@test -n "$(PYTHON)" || { echo "no python3 of version 3.10 or 3.11 found (pybullet has wheels for these); name one: make PYTHON=/path/to/python3.11"; exit 2; }
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt --editable '.[dev]'
	touch $@

$(INSTALLED)-bench: $(INSTALLED)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt --editable '.[bench]'
	touch $@

clean:  ## remove what was installed and made
	rm -rf .venv build dist runs *.egg-info
