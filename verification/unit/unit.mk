# `make unit` builds and runs the unit tests. With T= only the tests whose path contains one of its words
# are run, and only what they need is built.
#
# The Makefile includes this file. It is in the folder of the tests and of `runner`, the small runner that
# is used unless PFUNIT= names an installation of pFUnit.

RUNNER := verification/unit/runner
PF     := $(wildcard verification/unit/*/test_*.pf)
PF     := $(if $(T),$(sort $(foreach t,$(T),$(foreach f,$(PF),$(if $(findstring $t,$f),$f)))),\
          $(filter-out $(RUNNER)/%,$(PF)))
TESTS  := $(patsubst %.pf,$(U)/%.o,$(notdir $(PF)))
TESTF  := -std=gnu -g -Wall -Wno-maybe-uninitialized -Wno-uninitialized -Wno-unused-function \
          -ffree-line-length-none
vpath %.pf $(wildcard verification/unit/*)

.PHONY: unit runner
.PRECIOUS: $(U)/test_%.f90
unit: $(U)/run
	@$(U)/run $(ARGS)
runner:
	@$(MAKE) PFUNIT= U=$(B)/runner T=$(RUNNER) $(B)/runner/run
	@$(B)/runner/run -v | $(PY) $(RUNNER)/check.py
$(U)/run: FORCE $(TESTS) $(U)/driver.o $(if $(T),,$(B)/libbezel.a)
	@rm -f $(U)/lib.a; ar rcs $(U)/lib.a $$(ls $(B)/*.o 2>/dev/null | grep -v '/main\.o$$') $(U)/funit*.o
	@$(FC) $(OPT) $(U)/driver.o $(TESTS) $(U)/lib.a $(PFUNIT_LIBRARIES) $(LIBS) -o $@
$(U)/test_%.o: $(U)/test_%.f90 $(U)/funit.o
	$(TELL)
	@$(FC) $(TESTF) $(OPT) $(INCLUDE) $(PFUNIT_EXTRA_FFLAGS) -I$(B) -J$(U) -c $< -o $@
$(U)/driver.o: $(U)/driver.f90 $(TESTS) $(U)/funit.o
	@$(FC) $(TESTF) $(OPT) $(PFUNIT_EXTRA_FFLAGS) -J$(U) -c $< -o $@
ifndef PFUNIT
$(U)/funit_value.o $(U)/funit.o: $(U)/%.o: $(RUNNER)/%.f90 $(B)/flags
	@mkdir -p $(U); $(FC) $(TESTF) $(OPT) -J$(U) -c $< -o $@
$(U)/funit.o: $(U)/funit_value.o
$(U)/test_%.f90: test_%.pf $(RUNNER)/pf.py
	@mkdir -p $(U); $(PY) $(RUNNER)/pf.py test $< $@
$(U)/driver.f90: FORCE
	@mkdir -p $(U); $(PY) $(RUNNER)/pf.py driver $@.new $(PF)
	@cmp -s $@.new $@ && rm $@.new || mv $@.new $@
else
include $(wildcard $(PFUNIT)/PFUNIT-*/include/PFUNIT.mk)
TESTF += -cpp -Wno-unused-label
$(U)/test_%.f90: test_%.pf $(RUNNER)/pf.py
	@mkdir -p $(U); $(PY) $(RUNNER)/pf.py join $< $(U)/$(<F)
	@$(PFUNIT_BIN_DIR)/funitproc -quiet $(U)/$(<F) $@
$(U)/driver.f90: FORCE
	@printf '%s\n' $(patsubst %,'ADD_TEST_SUITE(%_suite)',$(basename $(notdir $(PF)))) > $(U)/suites.inc
	@printf '%s\n' '#define _TEST_SUITES "$(abspath $(U))/suites.inc"' '#include "driver.F90"' > $@
$(U)/funit.o:
	@mkdir -p $(U); touch $(U)/none.f90; $(FC) -c $(U)/none.f90 -o $@
endif
