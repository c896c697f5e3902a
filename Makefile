# Every command of the project: `make help` lists them.
.SUFFIXES:
.DELETE_ON_ERROR:

# --- Variables of the command line -------------------------------------------------------------
ifeq ($(origin FC),default)
FC     := $(if $(filter 1 yes,$(MPI)),mpifort,gfortran)
endif
KIND   ?= release
BUILD  ?= build
J      ?= $(shell nproc 2>/dev/null || echo 1)
NATIVE ?=
PFUNIT ?=
MINUTES ?= 60
SEED   ?= 1
T      ?=
MPI    ?=
RANKS  := $(filter 1 yes,$(MPI))
export MPI
B      := $(BUILD)/$(if $(RANKS),mpi$(KIND:release=),$(KIND))
U      := $(B)/$(if $(PFUNIT),pfunit,unit)
PYTHON := .venv/bin/python
PY     := $(or $(wildcard $(PYTHON)),python3)
MAKEFLAGS += --no-builtin-rules --no-print-directory $(if $(filter 0,$(MAKELEVEL)),-j$(J))

# --- Flags -------------------------------------------------------------------------------------
ifeq ($(filter $(KIND),release debug sanitize coverage),)
$(error KIND=$(KIND) is not one of release debug sanitize coverage)
endif
WARN         := -pedantic -Wall -Wextra -Wimplicit-interface -Wimplicit-procedure \
                -Wuse-without-only -Wno-maybe-uninitialized -Werror
OPT_release  := -O2 -g -ffp-contract=off
OPT_debug    := -Og -g -fcheck=all,no-array-temps -ffpe-trap=invalid,zero,overflow \
                -finit-real=snan -finit-derived -fbacktrace
OPT_sanitize := $(OPT_debug) -fsanitize=address,undefined -fno-omit-frame-pointer \
                -fno-sanitize=pointer-overflow -fno-var-tracking # without these two, it takes twice the time
OPT_coverage := -O0 -g --coverage -Wno-uninitialized # gives false warnings without optimisation
OPT          := $(OPT_$(KIND)) -fopenmp $(if $(filter-out 0 no,$(NATIVE)),-march=native)

# --- Libraries: where pkg-config says, else in the folders that distributions use ------------------
ROOTS      := $(wildcard /usr $(CONDA_PREFIX) $(MUMPS_DIR) $(HDF5_DIR) $(METIS_DIR))
HDF5_PC    := $(shell pkg-config --libs-only-L hdf5-serial 2>/dev/null)
HDF5_MOD   := $(firstword $(wildcard $(addsuffix /hdf5.mod,/usr/include/hdf5/serial \
              $(addsuffix /include,$(ROOTS)) /usr/lib64/gfortran/modules)))
INCLUDE    := $(addprefix -I,$(HDF5_MOD:/hdf5.mod=) $(wildcard $(addsuffix /include,$(ROOTS)) \
              $(if $(RANKS),,$(addsuffix /include/mumps_seq,$(ROOTS)))))
MUMPS_seq  := -ldmumps_seq -lsmumps_seq -lmumps_common_seq -lpord_seq -lmpiseq_seq
MUMPS_mpi  := -ldmumps -lsmumps -lmumps_common -lpord -lscalapack-openmpi
MUMPS_LIBS ?= $(MUMPS_$(if $(RANKS),mpi,seq))
LIBS       := $(or $(HDF5_PC),$(addprefix -L,$(wildcard /usr/lib/*/hdf5/serial))) \
              $(addprefix -L,$(wildcard $(addsuffix /lib,$(filter-out /usr,$(ROOTS))))) \
              $(MUMPS_LIBS) -lmetis -lhdf5_fortran -lhdf5 -lopenblas $(LDFLAGS)

# --- The program -------------------------------------------------------------------------------
.PHONY: all help FORCE
all: $(B)/bezel

# One module, base_comm, has two versions: for the ranks of MPI=1, and for a single process.
SOURCES := $(filter-out src/base/base_comm_$(if $(RANKS),serial,mpi).f90,$(wildcard src/*/*.f90))
include src/simd.mk
OBJECTS := $(patsubst %.f90,$(B)/%.o,$(notdir $(SOURCES) $(COPIES)))
vpath %.f90 $(wildcard src/*) $(sort $(dir $(COPIES)))

# Prints the names of the first three files that a make compiles, then their number after every 50.
TELL = @echo '$<' >> $(B)/compiled; n=$$(grep -nxF '$<' $(B)/compiled | sed 's/:.*//;q'); \
       if [ $$n -le 3 ]; then echo '  $<'; elif [ $$((n % 50)) = 0 ]; then echo "  $$n files compiled"; fi

# The compiler rewrites a module file only if its interface changes, so that its users are not recompiled.
$(B)/%.mod:
	@test -f $@ || { rm -f $<; echo "make: $@ is missing, run make again" >&2; exit 1; }
$(B)/%.o: %.f90 $(B)/flags | $(B)/libraries
	$(TELL)
	@$(FC) -std=f2008 $(WARN) $(OPT) $(call kernel,$*) $(INCLUDE) -J$(B) -c $< -o $@
$(B)/libbezel.a: $(OBJECTS)
	@rm -f $@; ar rcs $@ $(filter-out %/main.o,$^)
$(B)/bezel: $(B)/main.o $(B)/libbezel.a
	@$(FC) $(OPT) $^ $(LIBS) -o $@
	@echo "  $@"

# Checked once per build folder; one sentence names the libraries that are missing.
$(B)/libraries:
	@tools/setup.sh libraries && mkdir -p $(B) && touch $@
.PHONY: settings
settings:
	@echo "FC='$(FC)' INCLUDE='$(INCLUDE)' LIBS='$(LIBS)' MUMPS_LIBS='$(MUMPS_LIBS)'"
$(B)/flags: FORCE
	@mkdir -p $(B); echo '$(FC) $(WARN) $(OPT) $(INCLUDE)' > $@.new
	@cmp -s $@.new $@ && rm $@.new || mv $@.new $@
# Objects and modules whose source is gone are removed: a stale module would still be found.
$(B)/depend.mk: FORCE $(COPIES)
	@rm -f $(foreach o,$(filter-out $(OBJECTS),$(wildcard $(B)/*.o)),$o $(o:.o=.mod))
	@mkdir -p $(B); awk -v b=$(B) -v u='$$(U)' -f src/depend.awk $(SOURCES) $(COPIES) $(wildcard verification/unit/*/*.pf) > $@.new
	@cmp -s $@.new $@ && rm $@.new || mv $@.new $@
FORCE:
# Goals that compile: without depend.mk, the files that changed would be compiled, but not the users of
# their modules.
COMPILES := all unit install deb deck_errors reference patch trouble manual bench_parts references $(B)/%
ifneq ($(filter $(COMPILES),$(or $(MAKECMDGOALS),all)),)
$(shell rm -f $(B)/compiled)
include $(B)/depend.mk
endif

# --- Tests -------------------------------------------------------------------------------------
include verification/unit/unit.mk
include tools/packages/packages.mk

.PHONY: check tests deck_errors post_tests reference patch trouble ranks bench_parts setup
setup:
	@tools/setup.sh
check: setup
	@$(MAKE) tests
GOALS := $(if $(RANKS),ranks patch,runner unit deck_errors manual post_tests reference patch trouble bench_parts)
WHAT_runner      := the runner of the unit tests must report failures as failures
WHAT_unit        := unit tests, which are compiled first (some minutes)
WHAT_deck_errors := bad decks, each of which must give its expected message
WHAT_manual      := every word has a page and an example; every element and law has theory and tests
WHAT_post_tests  := tests of post, verify and tools; one dot per test
WHAT_reference   := the second implementation against the program, on the smallest meshes
WHAT_patch       := patch tests: comparisons with exact answers
WHAT_ranks       := the serial program against 1, 2 and 3 ranks; kills, signals, limits, restarts
WHAT_trouble     := files, signals, restarts; then decks that must not go wrong silently
WHAT_bench_parts := the programs of make bench must compile; they are not run
tests:
	@$(MAKE) $(B)/bezel
	@failed=; $(foreach goal,$(GOALS),echo "== $(goal): $(WHAT_$(goal))"; \
	  $(MAKE) $(goal) || failed="$$failed $(goal)"; ) \
	[ -z "$$failed" ] || { echo "make: failed:$$failed" >&2; exit 1; }
deck_errors: $(B)/bezel
	@$(PYTHON) -m verification.deck_errors.run --bezel $<
post_tests:
	@$(PYTHON) -W error::DeprecationWarning:post -m unittest discover -s post/tests -t .
reference: $(B)/bezel
	@OPENBLAS_NUM_THREADS=1 BEZEL=$< $(PYTHON) -m unittest discover -s verification/reference/tests -t .
PATCHES := $(patsubst verification/patch/%/expect.toml,%,$(wildcard verification/patch/*/expect.toml))
patch: $(B)/bezel
	@$(PYTHON) -m verification.verify --bezel $< --out $(B)/verify $(addprefix --case ,$(PATCHES)) \
	  > $(B)/patch.txt; code=$$?; grep -v '  ok$$' $(B)/patch.txt; exit $$code

# Compares the program for several ranks (MPI=1) with the serial one, which needs MUMPS without MPI.
ranks:
	@MPI= tools/setup.sh
	@$(MAKE) MPI= $(BUILD)/release/bezel
	@$(MAKE) MPI=1 $(BUILD)/mpi/bezel
	@$(PYTHON) -m verification.ranks --bezel $(BUILD)/mpi/bezel --serial $(BUILD)/release/bezel $(ARGS)

# Files, signals, limits and restarts, then decks that must not go wrong silently.
trouble: $(B)/bezel
	@BEZEL=$< $(PYTHON) -m unittest discover -s verification/trouble -t .
	@$(PYTHON) -m verification.verify --bezel $< --out $(B)/verify --case silent \
	  > $(B)/silent.txt; code=$$?; grep -v '  ok$$' $(B)/silent.txt; exit $$code

.PHONY: verify verify-all verify-long references mutants soak tradeoff bench demo demo-rocker
verify: setup
	@$(MAKE) $(B)/bezel
	@$(PYTHON) -m verification.verify --bezel $(B)/bezel
verify-all: setup
	@$(MAKE) $(B)/bezel
	@$(PYTHON) -m verification.verify --bezel $(B)/bezel --all
	@$(PYTHON) -m verification.restart.run $(B)/bezel
	@$(PYTHON) -m verification.verify --bezel $(B)/bezel --recover
	@$(MAKE) references mutants # at the same time: the references take one core
	@tools/setup.sh mesh || echo "section 3: checks that need Gmsh or TetGen are skipped" >&2
	@$(PYTHON) -m verification.section3 check --bezel $(B)/bezel --work $(BUILD)/section3
	@$(PYTHON) -m verification.section5_contact --bezel $(B)/bezel --mesh 1 2 --jobs $(J) $(ARGS)
	@$(PYTHON) -m verification.section5_debonding --bezel $(B)/bezel --suite all --jobs $(J) $(ARGS)
# All results of the second implementation, compared with the program.
references: $(B)/bezel
	@OPENBLAS_NUM_THREADS=1 $(PYTHON) -m verification.reference all --compare $<
# 500 mutated decks, meshes and splines under the sanitizers; make sanitize runs the tests under them.
mutants: setup
	@$(MAKE) KIND=sanitize $(BUILD)/sanitize/bezel
	@$(PYTHON) -m verification.soak --mutants 500 --bezel $(BUILD)/sanitize/bezel --jobs $(J)
# Hostile inputs, kills, signals, limits and units for MINUTES minutes, drawn from SEED. ARGS=--write updates the page.
soak: setup
	@$(MAKE) $(B)/bezel
	@$(PYTHON) -m verification.soak --bezel $(B)/bezel --minutes $(MINUTES) --seed $(SEED) --jobs $(J) $(ARGS)
# Takes hours; can be interrupted and continued. ARGS=--write updates the committed tables.
verify-long: setup
	@$(MAKE) $(B)/bezel
	@$(PYTHON) -m verification.section5_contact --bezel $(B)/bezel --mesh 3 $(ARGS)
	@$(PYTHON) -m verification.section5_debonding --bezel $(B)/bezel --suite long $(ARGS)
# Errors and CPU seconds of contact, with their page and figures. Takes an hour; can be interrupted and continued.
tradeoff: setup
	@$(MAKE) $(B)/bezel
	@$(PYTHON) -m verification.tradeoff --bezel $(B)/bezel --out $(BUILD)/tradeoff $(ARGS)
	@$(PYTHON) -m verification.tradeoff.page
	@$(PYTHON) -m post.figures.tradeoff
demo: setup
	@$(MAKE) $(B)/bezel
	@$(PYTHON) -m post.figures.demo --bezel $(B)/bezel --out $(BUILD)/demo
# From a net of quads to a solved contact (section 3 of the paper); ARGS='--refine 1' gives a finer mesh.
demo-rocker: setup
	@tools/setup.sh mesh
	@$(MAKE) $(B)/bezel
	@$(PYTHON) -m post.figures.rocker --bezel $(B)/bezel --out $(BUILD)/rocker $(ARGS)

# Programs that time a part of bezel, verification/performance/<part>/bench_<part>.f90, come first, then decks.
BENCH := $(patsubst verification/performance/%.f90,$(B)/%,$(wildcard verification/performance/*/bench_*.f90))
bench:
	@tools/setup.sh bench
	@$(MAKE) $(B)/bezel $(BENCH)
	@$(if $(filter --scale,$(ARGS)), \
	  $(PYTHON) -m verification.performance.bench_scale --bezel $(B)/bezel --out $(BUILD)/bench/scale $(filter-out --scale,$(ARGS)), \
	  $(PYTHON) -m verification.performance.bench --bezel $(B)/bezel --out $(BUILD)/bench --parts $(BENCH) $(ARGS))
bench_parts: $(BENCH)
$(BENCH): $(B)/%: verification/performance/%.f90 $(B)/libbezel.a
	@mkdir -p $(@D); $(FC) -std=f2008 $(WARN) $(OPT) -J$(@D) -I$(B) $^ $(LIBS) -o $@

# The tests with a build that checks at run time; coverage prints which lines were executed.
.PHONY: debug sanitize coverage
debug sanitize: setup
	@$(MAKE) KIND=$@ tests
coverage:
	@tools/setup.sh dev
	@find $(BUILD)/coverage -name '*.gcda' -delete 2>/dev/null || true
	@$(MAKE) KIND=coverage tests
	@.venv/bin/gcovr --root . --filter src/ --object-directory $(BUILD)/coverage --gcov-ignore-parse-errors --txt

# --- Style and documents -----------------------------------------------------------------------
.PHONY: lint format doc manual clean help
PYTHONS := post tools verification
FORMAT  := .venv/bin/fprettify --indent 2 --line-length 100 --recursive src
lint:
	@tools/setup.sh dev
	@.venv/bin/fortitude check --config-file fortitude.toml src
	@.venv/bin/ruff check $(PYTHONS) && .venv/bin/ruff format --check $(PYTHONS)
	@awk -v strict=1 -f src/depend.awk $(SOURCES) > /dev/null
	@grep -oE '`[a-z][a-z0-9_]*`' doc/architecture.md | tr -d '`' | sort -u | while read -r name; do \
	  ls -d src/$$name src/*/$$name.f90 2>/dev/null | grep -q . || grep -rqE "(subroutine|function) $$name\b" src \
	    || echo "doc/architecture.md: src has no folder, module or procedure '$$name'"; \
	done | { ! grep .; }
	@difference=$$($(FORMAT) --diff 2>&1); [ -z "$$difference" ] || { echo "$$difference"; exit 1; }
format:
	@tools/setup.sh dev
	@$(FORMAT) && .venv/bin/ruff format $(PYTHONS)
# The pages have the form that repository viewers show (# Title, $$..$$ in a line, links to .md); this makes FORD's form.
FORD_FORM := '1s/^\# (.*)/---\ntitle: \1\n---/; s/(^|[^$$])\$$([^$$]+)\$$/\1\\(\2\\)/g; s/\]\(([A-Za-z0-9_/]+)\.md/](\1.html/g'
doc:
	@tools/setup.sh dev
	@rm -rf $(BUILD)/doc_source && mkdir -p $(BUILD) && cp -r doc $(BUILD)/doc_source
	@find $(BUILD)/doc_source -name '*.md' -exec sed -i -E $(FORD_FORM) {} +
	@.venv/bin/ford --quiet --src_dir $(abspath src) --output_dir $(abspath $(BUILD))/doc $(BUILD)/doc_source/ford.md
	@echo "  $(BUILD)/doc/index.html"
manual: $(B)/bezel
	@$(PYTHON) tools/rows.py --bezel $<
	@$(PYTHON) tools/grammar.py --bezel $<
	@$(PYTHON) tools/manual.py --bezel $< --out $(B)/manual $(if $(filter release,$(KIND)),,--longest 60)
clean:
	@rm -rf $(BUILD)

#: make               $(BUILD)/release/bezel
#: make check         all that a commit must pass: unit tests, bad decks, manual, post, reference, patch tests, files, signals
#: make MPI=1         $(BUILD)/mpi/bezel for mpirun; make check MPI=1 tests it on 1, 2 and 3 ranks
#: make unit T=word   builds and runs the unit tests whose path contains the word
#: make verify        patch tests, contact, quick benchmarks; verify-all adds slow ones, restarts, mutants, the paper
#: make soak          random trials (bad input, kills, signals, limits, units); MINUTES= and SEED= set time and choice
#: make demo          runs three decks and draws their figures
#: make demo-rocker   meshes a body below a net of quads, slides a pin on it; needs Gmsh or TetGen
#: make tradeoff      accuracy against cost of the contact options (takes an hour)
#: make bench         times bezel and its parts, and compares them with the record
#: make debug | sanitize | coverage   the tests with run-time checks, sanitizers, or coverage of lines
#: make lint | format                 checks style and layers | formats the sources
#: make doc | manual                  pages in $(BUILD)/doc | checks pages and examples of all deck words
#: make install       installs into PREFIX=/usr/local, below DESTDIR=; make deb makes a Debian package
#: make clean         removes $(BUILD)/
#:
#: check, demo and verify install what is missing (apt, pip), or name it if they lack the permission.
#: Variables: J= jobs ($(J)), BUILD= folder for builds, NATIVE=1 optimises for this processor, FC= compiler,
#: PFUNIT= a pFUnit 4.14 to use for the unit tests, MUMPS_DIR= METIS_DIR= HDF5_DIR= prefixes,
#: MUMPS_LIBS= the libraries of MUMPS, LDFLAGS= further flags for linking.
help:
	@sed -n 's/^#: \{0,1\}//p' Makefile | sed 's|$$(BUILD)|$(BUILD)|g; s|$$(J)|$(J)|g'
