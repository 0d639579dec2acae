# make demo   a machine that is no longer as its model knows it: where the model fails, what is missing, the error after
# make live   a simulated rig on a bus, sixty times as fast as it would be, and the monitor beside it
# make test   everything that must hold, but for studies that take minutes: make bench runs these
PYTHON ?= $(shell command -v python3.11 || command -v python3)
VENV := .venv
BIN := $(VENV)/bin
READY := $(VENV)/.ready
PEERS := $(VENV)/.peers

FITTED := FS-20 FS-5 CS-10 ES-2.5
TWELVE := FS-20 FS-10 FS-5 FS-2.5 CS-20 CS-10 CS-5 CS-2.5 ES-20 ES-10 ES-5 ES-2.5
LOGS := $(TWELVE:%=recordings/%.blf)
HIDDEN := recordings/machine-7
MODEL := $(HIDDEN)/healthy.toml
SHOWN := FS-20

.PHONY: demo live review test newest check bench bench-engine bench-search bench-live bench-faults study-fit study-hidden study-machines pictures pictures-improve recordings model machine-7 tuning tuning-test clean

demo: $(READY)
	$(BIN)/ballscrew diagnose $(HIDDEN) --model $(MODEL)
	$(BIN)/ballscrew improve $(HIDDEN) --held-out $(HIDDEN)/held-out --model $(MODEL) -o improved.toml --view

review: $(READY) recordings/FS-20.blf
	$(BIN)/ballscrew review recordings/FS-20.blf --save demo.rrd --view

PORT := 28610
BUS := --interface socketcand --channel can0 --bus-kwargs host=127.0.0.1 port=$(PORT) --speed-up 60
VIEW := $(if $(DISPLAY)$(WAYLAND_DISPLAY),native,web)

live: $(READY)
	@$(BIN)/ballscrew hub --port $(PORT) --quiet & hub=$$!; \
	$(BIN)/ballscrew simulate $(SHOWN) $(BUS) --quiet & rig=$$!; \
	trap 'kill $$hub $$rig 2>/dev/null' EXIT INT TERM; \
	$(BIN)/ballscrew live $(BUS) --record recorded --view $(VIEW)

test: $(READY)
	$(BIN)/python -m pytest -n 2 --dist worksteal

# the same with the newest packages that pyproject.toml allows, whatever constraints.txt says; PYTHON names another Python
newest:
	$(PYTHON) -m venv .newest
	.newest/bin/python -m pip install --quiet --disable-pip-version-check --upgrade --editable '.[dev]'
	.newest/bin/python -m pytest -n 2 --dist worksteal

check: $(READY)
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/python -m pytest -n 2 --dist worksteal

bench: $(PEERS) $(LOGS)
	$(BIN)/python -m benchmarks
	$(BIN)/python -m pytest -m study

bench-search: $(LOGS)
	$(BIN)/python -m benchmarks search

bench-live: $(READY)
	$(BIN)/python -m benchmarks live

# thermometers that fail, one by one and together: some 40 minutes; goes on where it was stopped
bench-faults: $(READY)
	$(BIN)/python -m benchmarks faults

bench-engine: $(PEERS) $(FITTED:%=recordings/%.blf)
	$(BIN)/python -m benchmarks engine

study-fit: $(READY)
	$(BIN)/python -m benchmarks recovery

# a model fitted to each of twenty machines: forty minutes on two cores; goes on where it was stopped
# WORDS="101-104 runs" does a part of it, see benchmarks/machines.py
study-machines: $(READY)
	$(BIN)/python -m benchmarks machines $(WORDS)

# which effect is missing, every case on a machine of its own: some two hours on two cores; goes on where it was stopped
# WORDS="one healthy 0-9" does a part of it, WORDS=whole all of it, over night: see benchmarks/hidden/__init__.py
study-hidden: $(READY)
	$(BIN)/python -m benchmarks hidden $(WORDS)

pictures: $(READY) $(LOGS) pictures-improve
	$(BIN)/ballscrew review recordings/FS-20.blf --quiet --save demo.rrd
	$(BIN)/python -m viz.viewer.pictures demo.rrd docs/pictures --window 1366x768 --only Overview --only "How sure" --only "At the table" --only Residuals
	$(BIN)/ballscrew review $(LOGS) --quiet --save twelve.rrd
	$(BIN)/python -m viz.viewer.pictures twelve.rrd docs/pictures --window 1366x768 --only Accuracy
	$(BIN)/python -m docs.live_pictures

# HIDDEN=FOLDER names other recordings of a machine with an effect that MODEL has not
pictures-improve: $(READY)
	$(BIN)/ballscrew improve $(HIDDEN) --held-out $(HIDDEN)/held-out --model $(MODEL) --quiet -o improved.toml
	mkdir -p docs/pictures/improve
	cp improved-*.png docs/pictures/improve

recordings: $(LOGS)

model: $(READY) $(FITTED:%=recordings/%.blf)
	$(BIN)/ballscrew fit $(FITTED:%=recordings/%.blf) -o recordings/model.toml
	$(BIN)/ballscrew tune $(FITTED:%=recordings/%.blf) -o recordings/model.toml

# the machine of the demo while it is healthy, its model, and its recordings once its grease churns: some five minutes
machine-7: $(READY)
	mkdir -p recordings/machine-7/healthy recordings/machine-7/held-out
	for run in $(FITTED); do $(BIN)/ballscrew simulate $$run --machine 7 --seed 7 -o recordings/machine-7/healthy/$$run.blf; done
	$(BIN)/ballscrew fit recordings/machine-7/healthy -o recordings/machine-7/healthy.toml
	$(BIN)/ballscrew tune recordings/machine-7/healthy --model recordings/machine-7/healthy.toml -o recordings/machine-7/healthy.toml
	for run in FS-20 CS-10 ES-20 held-out/FS-10; do \
	  $(BIN)/ballscrew simulate $$(basename $$run) --machine 7 --seed 8 --cycles 1 --plant churning -o recordings/machine-7/$$run.blf; \
	done

recordings/%.blf: | $(READY)
	$(BIN)/ballscrew simulate $* -o $@

# RIG=PATH judges another rig folder than the paper's
tuning-test: $(READY)
	$(BIN)/python -m pytest tests/tuning$(if $(RIG),/test_tuning.py --rig-folder '$(RIG)')

tuning: $(READY)
	@$(BIN)/python -m tests.tuning.renew --reason '$(subst ','\'',$(REASON))' $(if $(RIG),--rig-folder '$(RIG)')

$(READY): pyproject.toml constraints.txt
	@echo "setting up $(VENV): Python packages, some 600 MB; a few minutes the first time"
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt --editable '.[dev]'
	$(BIN)/ballscrew warm
	touch $@

$(PEERS): $(READY)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt --editable '.[bench]'
	touch $@

clean:
	rm -rf $(VENV) .newest build *.egg-info *.rrd improved* recorded
