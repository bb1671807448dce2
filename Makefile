# Builds and installs the library for C and C++. For everything else see CONTRIBUTING.md.
#
#   make                               builds the shared and the static library
#   make install PREFIX=/opt/cylfuse   headers, libraries, pkg-config file, CMake package; `prefix=` means the same
#   make uninstall PREFIX=/opt/cylfuse removes them
#   make deb                           a pair of Debian packages in $(TARGET)/deb
#   make sbom                          what the library is made of, as a CycloneDX bill of materials in $(TARGET)
#
# DESTDIR stages an installation; LIBDIR may differ from $(PREFIX)/lib; STRIP=: keeps the line tables; PROFILE=release takes
# the library of `cargo build --release`, which is not optimised as a whole and compiles faster.

# `make prefix=...` wins over a PREFIX of the environment.
ifeq ($(origin prefix),command line)
PREFIX = $(prefix)
endif
PREFIX ?= /usr/local
DESTDIR ?=
LIBDIR ?= $(PREFIX)/lib
INCLUDEDIR = $(PREFIX)/include
# A space ends a path here, and `rm` would take the rest for another one. An `x` on either side shows those at the ends.
$(foreach name,PREFIX LIBDIR INCLUDEDIR DESTDIR,$(if $(word 2,x$($(name))x),\
	$(error $(name) is "$($(name))"; it must have no spaces)))
CARGO ?= cargo
CARGO_FLAGS ?=
PROFILE ?= dist
STRIP ?= strip
TARGET = $(or $(CARGO_TARGET_DIR),target)
BUILT = $(TARGET)/$(PROFILE)

VERSION := $(shell sed -n 's/^version = "\(.*\)"/\1/p' Cargo.toml | head -n 1)
# As in build.rs: before 1.0 a minor version may break the interface.
SOVERSION := $(shell echo $(VERSION) | awk -F. '{ print ($$1 == 0 ? "0." $$2 : $$1) }')
# What `rustc --print native-static-libs` lists, which programs need beside the static library.
SYSTEM_LIBRARIES = gcc_s util rt pthread m dl c

CMAKEDIR = $(LIBDIR)/cmake/cylfuse
PKGCONFIGDIR = $(LIBDIR)/pkgconfig
# From one folder to another, so that the whole tree can be moved.
path_from = $(shell realpath -m --relative-to=$(1) $(2))
# pkg-config leaves /usr/include out only where it is called so.
PKGCONFIG_PREFIX = $(if $(filter /usr,$(PREFIX)),/usr,$${pcfiledir}/$(call path_from,$(PKGCONFIGDIR),$(PREFIX)))

SUBSTITUTE = sed \
	-e 's|@VERSION@|$(VERSION)|g' \
	-e 's|@SOVERSION@|$(SOVERSION)|g' \
	-e 's|@PREFIX_FROM_CMAKEDIR@|$(call path_from,$(CMAKEDIR),$(PREFIX))|g' \
	-e 's|@LIBDIR_FROM_PREFIX@|$(call path_from,$(PREFIX),$(LIBDIR))|g' \
	-e 's|@PKGCONFIG_PREFIX@|$(PKGCONFIG_PREFIX)|g' \
	-e 's|@SYSTEM_LIBRARIES@|$(SYSTEM_LIBRARIES)|g' \
	-e 's|@SYSTEM_LIBRARY_FLAGS@|$(addprefix -l,$(SYSTEM_LIBRARIES))|g'

.PHONY: build install install-runtime install-dev uninstall deb sbom

LIBRARIES = $(BUILT)/libcylfuse.so $(BUILT)/libcylfuse.a

build: $(LIBRARIES)

# So that `make && sudo make install` leaves the compiler alone the second time.
$(LIBRARIES) &: Cargo.toml Cargo.lock build.rs $(shell find src -name '*.rs' -not -path 'src/bin/*')
	$(CARGO) build --locked --profile $(PROFILE) --lib $(CARGO_FLAGS)
	touch -c $(LIBRARIES)

install: install-runtime install-dev

install-runtime: $(LIBRARIES)
	install -d $(DESTDIR)$(LIBDIR)
	install -m 644 $(BUILT)/libcylfuse.so $(DESTDIR)$(LIBDIR)/libcylfuse.so.$(VERSION)
	$(STRIP) --strip-unneeded $(DESTDIR)$(LIBDIR)/libcylfuse.so.$(VERSION)
	ln -sf libcylfuse.so.$(VERSION) $(DESTDIR)$(LIBDIR)/libcylfuse.so.$(SOVERSION)

install-dev: $(LIBRARIES)
	install -d $(DESTDIR)$(LIBDIR) $(DESTDIR)$(INCLUDEDIR)/cylfuse $(DESTDIR)$(CMAKEDIR) $(DESTDIR)$(PKGCONFIGDIR)
	install -m 644 include/cylfuse/*.h include/cylfuse/*.hpp $(DESTDIR)$(INCLUDEDIR)/cylfuse
	install -m 644 $(BUILT)/libcylfuse.a $(DESTDIR)$(LIBDIR)/libcylfuse.a
	$(STRIP) --strip-debug $(DESTDIR)$(LIBDIR)/libcylfuse.a
	ln -sf libcylfuse.so.$(SOVERSION) $(DESTDIR)$(LIBDIR)/libcylfuse.so
	@echo 'cylfuse.pc and the CMake package, with the paths put in'
	@$(SUBSTITUTE) packaging/cylfuse.pc.in > $(DESTDIR)$(PKGCONFIGDIR)/cylfuse.pc
	@$(SUBSTITUTE) packaging/cylfuse-config.cmake.in > $(DESTDIR)$(CMAKEDIR)/cylfuse-config.cmake
	@$(SUBSTITUTE) packaging/cylfuse-config-version.cmake.in > $(DESTDIR)$(CMAKEDIR)/cylfuse-config-version.cmake

uninstall:
	rm -f $(DESTDIR)$(LIBDIR)/libcylfuse.so* $(DESTDIR)$(LIBDIR)/libcylfuse.a $(DESTDIR)$(PKGCONFIGDIR)/cylfuse.pc
	rm -rf $(DESTDIR)$(INCLUDEDIR)/cylfuse $(DESTDIR)$(CMAKEDIR)

deb: $(LIBRARIES)
	PROFILE=$(PROFILE) packaging/deb.sh $(VERSION) $(SOVERSION) $(TARGET)/deb

sbom:
	packaging/sbom.sh $(TARGET)/cylfuse-$(VERSION).cdx.json
