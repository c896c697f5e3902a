# Every command of the project: `make help` lists them.
.SUFFIXES:
.DELETE_ON_ERROR:

# --- Variables of the command line -------------------------------------------------------------
ifeq ($(origin FC),default)
FC     := gfortran
endif
KIND   ?= release
BUILD  ?= build
J      ?= $(shell nproc 2>/dev/null || echo 1)
NATIVE ?=
PFUNIT ?=
T      ?=
B      := $(BUILD)/$(KIND)
PYTHON := .venv/bin/python
MAKEFLAGS += --no-builtin-rules --no-print-directory -j$(J)

# --- Flags -------------------------------------------------------------------------------------
ifeq ($(filter $(KIND),release debug sanitize coverage),)
$(error KIND=$(KIND) is not one of release debug sanitize coverage)
endif
WARN         := -pedantic -Wall -Wextra -Wimplicit-interface -Wimplicit-procedure \
                -Wuse-without-only -Wno-maybe-uninitialized -Werror
OPT_release  := -O2 -g -ffp-contract=off
OPT_debug    := -Og -g -fcheck=all,no-array-temps -ffpe-trap=invalid,zero,overflow \
                -finit-real=snan -finit-derived -fbacktrace
OPT_sanitize := $(OPT_debug) -fsanitize=address,undefined -fno-omit-frame-pointer
OPT_coverage := -O0 -g --coverage
OPT          := $(OPT_$(KIND)) -fopenmp-simd $(if $(NATIVE),-march=native)
# Files whose inner loops carry the run time.
KERNELS      := solid_batch solid_form
kernel        = $(and $(filter release,$(KIND)),$(filter $(KERNELS),$1),-O3)

# --- Libraries: asked from pkg-config, else looked for where the distributions have them ---------
PREFIX     := $(wildcard /usr $(CONDA_PREFIX) $(MUMPS_DIR) $(HDF5_DIR) $(METIS_DIR))
HDF5_PC    := $(shell pkg-config --libs-only-L hdf5-serial 2>/dev/null)
HDF5_MOD   := $(firstword $(wildcard $(addsuffix /hdf5.mod,/usr/include/hdf5/serial \
              $(addsuffix /include,$(PREFIX)) /usr/lib64/gfortran/modules)))
INCLUDE    := $(addprefix -I,$(HDF5_MOD:/hdf5.mod=) $(wildcard $(addsuffix /include,$(PREFIX)) \
              $(addsuffix /include/mumps_seq,$(PREFIX))))
LIBS       := $(or $(HDF5_PC),$(addprefix -L,$(wildcard /usr/lib/*/hdf5/serial))) \
              $(addprefix -L,$(wildcard $(addsuffix /lib,$(filter-out /usr,$(PREFIX))))) \
              -ldmumps_seq -lsmumps_seq -lmumps_common_seq -lpord_seq -lmpiseq_seq -lmetis \
              -lhdf5_fortran -lhdf5 -lopenblas $(LDFLAGS)

# --- The program -------------------------------------------------------------------------------
SOURCES := $(wildcard src/*/*.f90)
ifdef MPI
$(error MPI=1 is not available yet)
endif
SOURCES := $(filter-out %/base_comm_mpi.f90,$(SOURCES))
OBJECTS := $(patsubst %.f90,$(B)/%.o,$(notdir $(SOURCES)))
vpath %.f90 $(wildcard src/*)

.PHONY: all help FORCE
all: $(B)/bezel

# A module file keeps its time while the interface is the same: what uses it is then not compiled again.
$(B)/%.mod:
	@test -f $@ || { rm -f $<; echo "make: $@ is missing, run make again" >&2; exit 1; }
$(B)/%.o: %.f90 $(B)/flags
	@echo "  $<"
	@$(FC) -std=f2008 $(WARN) $(OPT) $(call kernel,$*) $(INCLUDE) -J$(B) -c $< -o $@
$(B)/libbezel.a: $(OBJECTS)
	@rm -f $@; ar rcs $@ $(filter-out %/main.o,$^)
$(B)/bezel: $(B)/main.o $(B)/libbezel.a
	@$(FC) $(OPT) $^ $(LIBS) -o $@
	@echo "  $@"

$(B)/flags: FORCE
	@mkdir -p $(B); echo '$(FC) $(WARN) $(OPT) $(INCLUDE)' > $@.new
	@cmp -s $@.new $@ && rm $@.new || mv $@.new $@
$(B)/depend.mk: FORCE
	@mkdir -p $(B); awk -v b=$(B) -f src/depend.awk $(SOURCES) $(wildcard verification/unit/*/*.pf) > $@.new
	@cmp -s $@.new $@ && rm $@.new || mv $@.new $@
FORCE:
ifneq ($(filter-out help clean setup,$(or $(MAKECMDGOALS),all)),)
include $(B)/depend.mk
endif

# --- Unit tests: T= chooses those whose path has a word of it and builds no more than they need ---
U      := $(B)/unit
RUNNER := verification/unit/runner
PF     := $(wildcard verification/unit/*/test_*.pf)
PF     := $(if $(T),$(sort $(foreach t,$(T),$(foreach f,$(PF),$(if $(findstring $t,$f),$f)))),\
          $(filter-out $(RUNNER)/%,$(PF)))
TESTS  := $(patsubst %.pf,$(U)/%.o,$(notdir $(PF)))
TESTF  := -std=gnu -g -Wall -Wno-maybe-uninitialized -Wno-uninitialized -Wno-unused-function \
          -ffree-line-length-none
vpath %.pf $(wildcard verification/unit/*)
vpath funit%.f90 $(RUNNER)

.PHONY: unit runner
.PRECIOUS: $(U)/%.f90
unit: $(U)/run
	@$(U)/run $(ARGS)
runner:
	@$(MAKE) unit T=$(RUNNER) ARGS=-v | python3 $(RUNNER)/check.py
$(U)/run: FORCE $(U)/driver.o $(TESTS) $(if $(T),,$(B)/libbezel.a)
	@rm -f $(U)/lib.a; ar rcs $(U)/lib.a $$(ls $(B)/*.o | grep -v '/main\.o$$')
	@$(FC) $(OPT) $(U)/driver.o $(TESTS) $(U)/funit.o $(U)/funit_value.o $(U)/lib.a $(LIBS) -o $@
$(U)/driver.f90: FORCE
	@mkdir -p $(U); python3 $(RUNNER)/pf.py driver $@.new $(PF)
	@cmp -s $@.new $@ && rm $@.new || mv $@.new $@
$(U)/test_%.f90: test_%.pf $(RUNNER)/pf.py
	@mkdir -p $(U); python3 $(RUNNER)/pf.py test $< $@
$(U)/%.o: $(U)/%.f90 $(U)/funit.o
	@$(FC) $(TESTF) $(OPT) $(INCLUDE) -I$(B) -J$(U) -c $< -o $@
$(U)/driver.o: $(TESTS)
$(U)/funit.o $(U)/funit_value.o: $(U)/%.o: $(RUNNER)/%.f90 $(B)/flags
	@mkdir -p $(U); $(FC) $(TESTF) $(OPT) -J$(U) -c $< -o $@
$(U)/funit.o: $(U)/funit_value.o

help:
	@sed -n 's/^#: //p' Makefile
#: make                   build/release/bezel
