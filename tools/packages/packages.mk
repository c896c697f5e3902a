# `make install PREFIX= DESTDIR=` and `make deb`. The Makefile includes this file.
PREFIX  ?= /usr/local
DESTDIR ?=
PACKAGES := tools/packages
RELEASE  := $(shell sed -n "s/.*VERSION = '\(.*\)'.*/\1/p" src/base/program_version.f90)
MAINTAINER ?= the bezel developers <bezel@lists.example.org>
SHARED   := $(DESTDIR)$(PREFIX)/share

.PHONY: install deb
install: $(B)/bezel
	@install -d $(DESTDIR)$(PREFIX)/bin $(SHARED)/man/man1 $(SHARED)/bash-completion/completions $(SHARED)/bezel \
	  $(SHARED)/doc/bezel/examples
	@install -s $(B)/bezel $(DESTDIR)$(PREFIX)/bin/bezel
	@install $(PACKAGES)/bezel-post $(DESTDIR)$(PREFIX)/bin/bezel-post
	@for page in bezel bezel-post; do gzip -9n < $(PACKAGES)/$$page.1 > $(SHARED)/man/man1/$$page.1.gz; done
	@install -m 644 $(PACKAGES)/bezel.bash $(SHARED)/bash-completion/completions/bezel
	@ln -sf bezel $(SHARED)/bash-completion/completions/bezel-post
	@cd post && find . -name '*.py' ! -path './tests/*' ! -path './figures/*' -exec install -D -m 644 {} $(abspath $(SHARED))/bezel/post/{} \;
	@install -m 644 post/requirements.txt $(SHARED)/bezel/post/requirements.txt
	@cd input && find . -type f -exec install -D -m 644 {} $(abspath $(SHARED))/doc/bezel/examples/{} \;
	@install -m 644 CHANGELOG.md README.md LICENSE $(SHARED)/doc/bezel
	@echo "  $(DESTDIR)$(PREFIX)/bin/bezel, bezel-post; decks in $(SHARED)/doc/bezel/examples"

# A Debian package of what `install` puts into /usr; it depends on the libraries with which the program is linked.
deb: ROOT = $(BUILD)/deb/root
deb: $(B)/bezel
	@rm -rf $(BUILD)/deb && mkdir -p $(ROOT)/DEBIAN $(BUILD)/deb/debian
	@$(MAKE) install PREFIX=/usr DESTDIR=$(abspath $(ROOT)) > /dev/null
	@sh $(PACKAGES)/deb.sh $(ROOT) $(RELEASE)-1 '$(MAINTAINER)'
	@dpkg-deb --root-owner-group --build $(ROOT) $(BUILD)/bezel_$(RELEASE)-1_$$(dpkg --print-architecture).deb > /dev/null
	@echo "  $(BUILD)/bezel_$(RELEASE)-1_$$(dpkg --print-architecture).deb"
