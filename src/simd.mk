# Sources that are compiled for speed, and copies of some of them for wider vector registers.
#
# The Makefile includes this file. It is in src because its lists name sources, so that whoever renames a
# source finds them.

# Files whose inner loops take most of the run time. Their automatic arrays are small and are put on the
# stack, since allocating them would cost as much as the loops.
KERNELS      := solid_batch solid_batch_algebra solid_batch_condense solid_panel solid_point \
                solid_form solid_condense mate_neohooke mate_linear surface_geometry surface_basis \
                projection projection_iterate surface_traversal surface_chart contact_element contact_point \
                contact_work contact_bond edge_taper contact_facets contact_cells contact_mortar \
                mortar_slide mortar_kernel contact_scatter csr_coupling polygon bspline \
                element_sweep
# Files that are also compiled for wider vector registers, under other names (@ becomes _v3 or _v4); at
# run time the program chooses the widest that the processor supports (solid_simd). Fused multiply-adds
# save 15 % of the time here.
WIDE         := elements/solid_batch@ elements/solid_batch@_algebra elements/solid_batch@_condense \
                elements/solid_form@ elements/solid_panel@ elements/solid_point@ materials/mate_neohooke@
MARCH_v3     := -march=x86-64-v3 -ffp-contract=fast
MARCH_v4     := -march=x86-64-v4 -mprefer-vector-width=512 -ffp-contract=fast
wide          = $(and $(filter x86_64,$(shell uname -m)),$(MARCH$(findstring _v3,$1)$(findstring _v4,$1)))
kernel        = $(if $(filter release,$(KIND)),$(if $(filter $(KERNELS) $(addsuffix _v%,$(WIDENED)),$1),-O3 -fstack-arrays) \
                $(call wide,$1))

# The beginnings of names of modules that get _v3 or _v4.
WIDENED := $(sort $(foreach w,$(notdir $(WIDE)),$(firstword $(subst @, ,$w))))
SPACE   := $(subst ,, )
COPIES  := $(foreach v,_v3 _v4,$(patsubst %,$(B)/wide/%.f90,$(subst @,$v,$(WIDE))))

define copy
$(B)/wide/$(subst @,$2,$1).f90: src/$(subst @,,$1).f90
	@mkdir -p $$(@D); sed -E 's/\b($(subst $(SPACE),|,$(WIDENED)))/\1$2/g' $$< > $$@
endef
$(foreach v,_v3 _v4,$(foreach w,$(WIDE),$(eval $(call copy,$w,$v))))
