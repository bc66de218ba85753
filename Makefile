# Everything a user or a developer types. `make run` and `make test` set up what they need.

BIN := .venv/bin
MANUAL := resources/manual/index.html
MANUAL_SOURCES := $(shell find docs installers/manual resources/protocols resources/help resources/translations \
	-type f -not -path '*/__pycache__/*' -not -path 'docs/screenshots/*')

.PHONY: run test compile coverage check translations train screenshots figures manual installer \
	installer-check setup lock clean

## Open the program (where no display is found: the demo, and where its report lies).
run: setup manual
	$(BIN)/adibas

## Run all tests, without a display; what is compiled is compiled before, as in a window that has
## been open for a minute.
test: compile
	QT_QPA_PLATFORM=offscreen $(BIN)/python -m pytest -n 2 --dist loadfile --no-loadscope-reorder \
		--cov=adibas.geometry --cov=adibas.data --cov=adibas.errors --cov-report= \
		--durations=15 $(PYTEST_ARGS)
	$(BIN)/coverage report --skip-covered --fail-under=100 \
		--include='adibas/geometry/*,adibas/data/*,adibas/errors.py'

## Compile the hot loops, unless that is done.
compile: setup
	$(BIN)/python -m adibas.pipeline.warming

## Run all tests, and say which lines of the whole program none of them reaches.
coverage: compile
	QT_QPA_PLATFORM=offscreen $(BIN)/python -m pytest -n 2 --dist loadfile --no-loadscope-reorder \
		--cov $(PYTEST_ARGS)

## Style, types, and who may import whom.
check: setup
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

## Collect new texts into the catalogues of all languages, and compile these.
translations: setup
	$(BIN)/python -m installers.translations

## Train the shipped models of the 15 joints and of the limbs again on simulated people (three hours).
train: setup
	$(BIN)/adibas skeleton train --simulator --out resources/models/skeleton.json
	$(BIN)/adibas limbs train --simulator --seed 6215 --out resources/models/limbs-15.npz
	$(BIN)/adibas limbs train --simulator --seed 7101 --frames 64000 \
		--context resources/models/limbs-15.npz --out resources/models/limbs-15.npz
	$(BIN)/python -m adibas.pipeline.pose_training
	$(BIN)/python -m adibas.pipeline.facing_training
	$(BIN)/python -m adibas.pipeline.body_marks_training
	$(BIN)/python -m adibas.pipeline.likeness_training
	$(BIN)/python -m adibas.pipeline.reliability_training

setup:
	@installers/setup.sh

## Renew the locked dependencies (needs uv; names no index).
lock:
	uv pip compile pyproject.toml --extra dev --extra realsense --extra server --extra installer --universal --python-version 3.11 \
		--generate-hashes --no-emit-index-url --no-header --no-annotate -o installers/requirements.lock
	uv pip compile --group boris --universal --python-version 3.11 \
		--generate-hashes --no-emit-index-url --no-header --no-annotate -o installers/boris.lock

## Build the manual that the window opens (F1), where a source of it is newer; no network.
manual: $(MANUAL)

$(MANUAL): $(MANUAL_SOURCES) | setup
	$(BIN)/python -m installers.manual.build

## Draw the landmarks of each protocol on a body again, for the manual.
figures: setup
	$(BIN)/python -m installers.manual.figures

## Draw every screen in every language, theme and size, and the manual's set.
screenshots: setup
	$(BIN)/python -m installers.screenshots
	$(BIN)/python -m installers.screenshots --docs
	$(BIN)/python -m installers.screenshots --manual

## Build the program for computers without Python, and its Debian package; both go to dist/.
installer: setup manual
	@installers/setup.sh installer
	mkdir -p build
	$(BIN)/python -m installers.freezing
	$(BIN)/python -m installers.debian

## Install that package into a fresh Debian, try it out, remove it (root, debootstrap and Xvfb).
installer-check: setup
	installers/linux/check.sh

clean:
	rm -rf .venv .venv-boris build dist resources/manual
