# Sundog's targets. `make demo` and `make test` each do all the set-up that a fresh machine needs.
#
# Rust is taken from PATH, else from where its installer puts it.
export PATH := $(PATH):$(or $(CARGO_HOME),$(HOME)/.cargo)/bin

.PHONY: help demo test test-long setup build addon parity parity-random bench clean

help:
	@echo 'make demo    set up, build, and render one of the scenes (one minute once built)'
	@echo 'make test    set up, check format and lints, run all tests'
	@echo 'make test-long   what takes longer: long tests, the add-on in Blender 4.2, 4.5, 5.0 and 5.1, pictures beside Cycles of 4.5'
	@echo 'make build   set up and build target/release/sundog'
	@echo 'make addon   build the Blender extension with the program inside: dist/sundog-VERSION-linux-x64.zip'
	@echo 'make setup   system packages, Rust, Embree, OpenColorIO and libclang only'
	@echo 'make parity  compare every shader node with Cycles: BLENDER=5.2.3 FILTER=Noise,Mix FOLDER=out/parity (minutes)'
	@echo 'make parity-random   the same of random trees: KIND=sheet|ball|shader|volume|displacement FIRST=0 COUNT=400'
	@echo 'make bench   measure Sundog against Cycles, into docs/notes/benchmarks.md (long; an idle machine)'
	@echo 'make clean   remove what was built; the cache folder and .native/ stay'

setup:
	@scripts/setup.sh

# Programs for this machine take what its processor has; packages run on every one (docs/setup.md). Both know what is hot.
# Beside the flags of .cargo/config.toml; RUSTFLAGS of one's own take the place of both.
build: setup
	CARGO_TARGET_X86_64_UNKNOWN_LINUX_GNU_RUSTFLAGS="$$(scripts/cpu-flags.sh) $$(scripts/profile-flags.sh)" cargo build --release --locked

demo: build
	@scripts/demo.sh

addon: setup
	CARGO_TARGET_X86_64_UNKNOWN_LINUX_GNU_RUSTFLAGS="$$(scripts/profile-flags.sh)" cargo build --release --locked
	@python3 scripts/addon.py

test: setup
	@scripts/test.sh

test-long: setup
	@scripts/test-long.sh

bench: build
	@scripts/setup-bpy.sh 4.5.15
	@"$${SUNDOG_BPY_PYTHON:-$${XDG_CACHE_HOME:-$$HOME/.cache}/sundog/bpy-4.5.15/bin/python}" scripts/benchmark.py

BLENDER ?= 5.2.3
FILTER ?=
FOLDER ?= out/parity

parity: build
	@scripts/setup-bpy.sh "$(BLENDER)"
	@"$${XDG_CACHE_HOME:-$$HOME/.cache}/sundog/bpy-$(BLENDER)/bin/python" tests/addon/parity.py --filter "$(FILTER)" --folder "$(FOLDER)"

# Random trees beside Cycles: KIND sheet, ball, shader, volume or displacement, from the tree FIRST.
KIND ?= sheet
FIRST ?= 0
COUNT ?= 400

parity-random: build
	@scripts/setup-bpy.sh "$(BLENDER)"
	@"$${XDG_CACHE_HOME:-$$HOME/.cache}/sundog/bpy-$(BLENDER)/bin/python" tests/addon/parity_random.py $(KIND) --first $(FIRST) --count $(COUNT) --folder "$(FOLDER)-random"

clean:
	rm -rf target out dist
