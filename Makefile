# Eventmill: library, programs, tests. `make help` lists the targets.

# ---------------------------------------------------------------- knobs
BUILD   ?= build
PREFIX  ?= /usr/local
DESTDIR ?=
CC      := $(if $(filter default,$(origin CC)),gcc,$(CC))
NM      ?= nm
PKG_CONFIG ?= pkg-config
OPT     ?= -O3
JOBS    ?= $(shell nproc 2>/dev/null || echo 2)
T       ?=

VERSION := 0.1.0
SOMAJOR := 0

MAKEFLAGS += --no-builtin-rules
.SUFFIXES:
.DELETE_ON_ERROR:
.DEFAULT_GOAL := all

ifneq ($(words $(BUILD)),1)
  $(error BUILD='$(BUILD)', expected the name of one folder without blanks)
endif

Q := $(if $(V),,@)
say = $(if $(V),,@printf '  %-7s %s\n' $(1) $(2))

# Each kind of build has its own directory, so that none clobbers another.
B := $(BUILD)
ifneq ($(filter-out 0,$(SAN)),)
  B := $(B)/san
  KIND := -O1 -g -fsanitize=address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer
else ifneq ($(filter-out 0,$(DEBUG)),)
  B := $(B)/debug
  KIND := -O0 -g3
else
  KIND := $(OPT) -g -DNDEBUG
endif

# ---------------------------------------------------------------- compiler and libraries
PACKAGES := gsl hdf5 libconfig osmesa libpng cairo
MISSING  := $(shell command -v $(firstword $(PKG_CONFIG)) >/dev/null || { echo pkg-config; exit; }; \
  for p in $(PACKAGES); do $(PKG_CONFIG) --exists $$p 2>/dev/null || echo $$p; done)

# Flags that the user may add to, and those on which results depend: no fused multiply-add, no
# fast-math, so that a run has the same bits with every compiler.
CFLAGS   ?=
CPPFLAGS ?=
LDFLAGS  ?=
WARN  := -Wall -Wextra -Wpedantic -Wno-psabi -Wshadow -Wconversion -Wstrict-prototypes \
         -Wmissing-prototypes $(if $(WERROR),-Werror)
EXACT := -ffp-contract=off -fno-math-errno
HOUSE := -std=gnu11 -D_GNU_SOURCE $(KIND) $(EXACT) -fPIC -fno-semantic-interposition $(WARN)
SEEK  := -Iinclude -Isrc -I$(B)
PKG_CFLAGS := $(if $(MISSING),,$(patsubst -I%,-isystem %,$(shell $(PKG_CONFIG) --cflags $(PACKAGES))))
PKG_LIBS   := $(if $(MISSING),,$(shell $(PKG_CONFIG) --libs $(PACKAGES)))
LIBS  := $(PKG_LIBS) -lm

# What works on many numbers at a time is built beside the plain code and chosen at run time; never
# with -mfma, and AVX-512, which has it, without contraction.
FOR_AVX2   := -mavx2
FOR_AVX512 := $(FOR_AVX2) -mavx512f -mavx512dq -mavx512vl
ifneq ($(findstring x86_64,$(shell $(CC) -dumpmachine 2>/dev/null)),)
  AVX2 := yes
  HOUSE += -DEM_HAVE_AVX2
endif

ALL_CFLAGS = $(HOUSE) $(SEEK) $(CPPFLAGS) $(PKG_CFLAGS) $(CFLAGS)

# ---------------------------------------------------------------- what is built from what
LIB_SRC  := $(sort $(filter-out src/tool/% $(if $(AVX2),,%_avx2.c %_avx512.c),$(wildcard src/*/*.c)))
TOOL_SRC := $(sort $(wildcard src/tool/*.c))
LIB_OBJ  := $(LIB_SRC:%.c=$(B)/%.o)
TOOL_OBJ := $(TOOL_SRC:%.c=$(B)/%.o)
# Of src/tool, mill*.c makes mill, millpost*.c makes millpost, and both share the rest.
POST_OBJ := $(filter $(B)/src/tool/millpost%,$(TOOL_OBJ))
MILL_OBJ := $(filter-out $(POST_OBJ),$(filter $(B)/src/tool/mill%,$(TOOL_OBJ)))
BOTH_OBJ := $(filter-out $(POST_OBJ) $(MILL_OBJ),$(TOOL_OBJ))
PROGRAMS := $(B)/mill $(B)/millpost

STATIC := $(B)/libeventmill.a
SHARED := $(B)/libeventmill.so

TEST_SRC    := $(sort $(wildcard tests/*/test_*.c))
TEST_SH     := $(sort $(wildcard tests/*/test_*.sh))
SUPPORT_SRC := $(sort $(wildcard tests/support/*.c))
BENCH_SH    := $(sort $(wildcard tests/bench/bench_*.sh))
BENCH_SRC   := $(sort $(wildcard tests/bench/bench_*.c))
FUZZ_SRC    := $(sort $(wildcard tests/fuzz/fuzz_*.c))
TEST_BIN    := $(TEST_SRC:%.c=$(B)/%)
BENCH_BIN   := $(BENCH_SRC:%.c=$(B)/%)
REPLAY_BIN  := $(FUZZ_SRC:%.c=$(B)/%_replay)
FUZZ_BIN    := $(FUZZ_SRC:%.c=$(B)/%)
SUPPORT_OBJ := $(SUPPORT_SRC:%.c=$(B)/%.o)
TEST_LIBS   := -lcmocka -lmpfr -lgmp \
               $(if $(shell grep -ls quadmath.h tests/*/*.[ch]),-lquadmath)

.PHONY: all help setup packages demo check check-long hard bench fuzz install uninstall clean \
        lint format info build-tests force
all: packages $(STATIC) $(SHARED) $(PROGRAMS)

help:
	@echo 'all demo check check-long hard bench accuracy fuzz install uninstall clean lint format info'
	@echo 'SAN=1 DEBUG=1 V=1 JOBS=n CC=clang BUILD=dir PREFIX=dir DESTDIR=dir'
	@echo 'make check T=unit/test_error runs the tests whose path contains T'

# Without the libraries nothing compiles: say so before the compiler does.
packages:
ifneq ($(MISSING),)
	@echo "missing: $(MISSING). Run scripts/setup, which installs all that is needed on Debian," \
	  "or install pkg-config and the libraries' development packages." >&2; exit 1
endif

# ---------------------------------------------------------------- rules
# Files that change only when their content does.
define settle
@mkdir -p $(@D); cmp -s $@.new $@ && rm $@.new || mv $@.new $@
endef

$(B)/flags: force
	@mkdir -p $(@D); printf '%s\n' '$(CC) $(ALL_CFLAGS) $(FOR_AVX512)' >$@.new
	$(settle)

$(B)/link: force
	@mkdir -p $(@D); printf '%s\n' $(call shell_word,$(CC) $(KIND) $(LDFLAGS) $(LIBS)) >$@.new
	$(settle)

$(B)/version.h: force scripts/version
	@mkdir -p $(@D); scripts/version '$(VERSION)' '$(CC)' '$(KIND) $(EXACT) $(CFLAGS)' >$@.new
	$(settle)

$(B)/%.o: %.c $(B)/flags | packages $(B)/version.h
	$(call say,CC,$<)
	@mkdir -p $(@D)
	$(Q)$(CC) $(ALL_CFLAGS) $(if $(filter %_avx2.c,$<),$(FOR_AVX2)) \
	  $(if $(filter %_avx512.c,$<),$(FOR_AVX512)) -MMD -MP -c $< -o $@

$(B)/tests/%.o: private SEEK += -Itests

# The page of millpost view, as bytes in C.
VIEW_PAGE   := src/draw/view/page.html
VIEW_SCRIPT := $(addprefix src/draw/view/,run.js stage.js legend.js play.js)
bytes = { echo 'static const unsigned char $(1)[] = {'; cat $(2) | od -An -v -tu1 | \
  sed 's/\([0-9]\) /\1,/g; s/$$/,/'; echo '0};'; }
$(B)/view_page.h: $(VIEW_PAGE) $(VIEW_SCRIPT)
	@mkdir -p $(@D)
	$(Q){ $(call bytes,view_page,$(VIEW_PAGE)); $(call bytes,view_script,$(VIEW_SCRIPT)); } >$@
$(B)/src/draw/view.o: | $(B)/view_page.h

$(STATIC): $(LIB_OBJ) $(B)/members
	$(call say,AR,$@)
	$(Q)rm -f $@ && $(AR) rcs $@ $(LIB_OBJ)

# The list of members: an object that is gone must leave the library and the programs.
$(B)/members: force
	@mkdir -p $(@D); printf '%s\n' '$(LIB_OBJ) $(TOOL_OBJ)' >$@.new
	$(settle)

# What the shared library shows: of all that is in it, what the public headers declare.
HEADERS := $(wildcard include/eventmill/*.h)
$(B)/exports: $(STATIC) $(HEADERS)
	$(Q){ echo '{ global:'; { grep -oh 'em_[a-z0-9_]*' $(HEADERS) | sort -u; \
	  $(NM) -g --defined-only $(STATIC) | awk 'NF == 3 { print $$3 }' | sort -u; } | \
	  sort | uniq -d | sed 's/$$/;/'; echo 'local: *; };'; } >$@

$(SHARED): $(LIB_OBJ) $(B)/members $(B)/exports $(B)/link
	$(call say,LD,$@)
	$(Q)$(CC) $(KIND) -shared -Wl,-soname,libeventmill.so.$(SOMAJOR) \
	  -Wl,--version-script=$(B)/exports $(LDFLAGS) $(LIB_OBJ) $(LIBS) -o $@

# A program loads only the libraries that it uses: mill starts without those that draw.
$(B)/mill: $(MILL_OBJ)
$(B)/millpost: $(POST_OBJ)
$(PROGRAMS): $(BOTH_OBJ) $(STATIC) $(B)/members $(B)/link
	$(call say,LD,$@)
	$(Q)$(CC) $(KIND) $(LDFLAGS) -Wl,--as-needed $(filter %.o,$^) $(STATIC) $(LIBS) -o $@

$(TEST_BIN) $(BENCH_BIN): $(B)/%: $(B)/%.o $(SUPPORT_OBJ) $(STATIC) $(B)/link
	$(call say,LD,$@)
	$(Q)$(CC) $(KIND) $(LDFLAGS) $< $(SUPPORT_OBJ) $(STATIC) $(TEST_LIBS) $(LIBS) -o $@

$(REPLAY_BIN): $(B)/%_replay: $(B)/%.o $(B)/tests/fuzz/replay.o $(STATIC) $(B)/link
	$(call say,LD,$@)
	$(Q)$(CC) $(KIND) $(LDFLAGS) $(filter %.o,$^) $(STATIC) $(LIBS) -o $@

-include $(patsubst %.o,%.d,$(LIB_OBJ) $(TOOL_OBJ) $(SUPPORT_OBJ)) $(addsuffix .d,$(TEST_BIN) $(BENCH_BIN) $(FUZZ_BIN)) $(B)/tests/fuzz/replay.d

# ---------------------------------------------------------------- tests
# Tests are built in as many jobs as there are cores, unless the caller chose a number.
submake = $(MAKE) $(if $(findstring jobserver,$(MAKEFLAGS)),,-j$(JOBS)) --no-print-directory

# T picks tests by a part of their path; long ones only when asked for.
chosen = $(if $(T),$(foreach t,$(1),$(if $(findstring $(T),$(t)),$(t))),$(1))
short   = $(foreach t,$(1),$(if $(findstring /test_long_,$(t)),,$(t)))
picked  = $(call chosen,$(if $(LONG)$(T),$(1),$(call short,$(1))))

setup:
	@scripts/setup

check: setup
	@$(submake) run-tests

# Long tests get hours, each of them.
TEST_TIMEOUT_LONG ?= 28800
check-long: setup
	@TEST_TIMEOUT=$(TEST_TIMEOUT_LONG) $(submake) run-tests LONG=1

# The long form of the hard cases, and their table (docs/stability.md).
hard: setup
	@TEST_TIMEOUT=$(TEST_TIMEOUT_LONG) $(submake) run-tests LONG=1 T=tests/hard/test_long_; \
	  status=$$?; \
	  echo '| case | what is hard | tries | checked | worst error |'; \
	  echo '| --- | --- | --- | --- | --- |'; \
	  grep -h '^| ' $(B)/logs/hard-test_long_*.log; exit $$status

.PHONY: run-tests
run-tests: all $(call picked,$(TEST_BIN)) $(call chosen,$(REPLAY_BIN))
	@BUILD=$(B) JOBS=$(JOBS) scripts/run-tests $(call picked,$(TEST_BIN) $(TEST_SH)) \
	  $(call chosen,$(REPLAY_BIN))

build-tests: all $(TEST_BIN) $(REPLAY_BIN) $(BENCH_BIN)

bench: all $(call chosen,$(BENCH_BIN))
	@for b in $(call chosen,$(BENCH_BIN) $(BENCH_SH)); do echo "== $$b"; BUILD=$(B) $$b || exit 1; done

# What accuracy and effects cost on this machine: tables and pictures in $(B)/accuracy.
.PHONY: accuracy
accuracy: all
	@BUILD=$(B) scripts/accuracy

# Fuzzing for FUZZ_TIME seconds per target, from the stored corpus.
FUZZ_TIME ?= 60
fuzz:
	@scripts/setup fuzz
	@$(submake) CC=clang SAN=1 BUILD=$(BUILD)/fuzz CFLAGS='$(CFLAGS) -fsanitize=fuzzer-no-link' \
	  run-fuzz

.PHONY: run-fuzz
run-fuzz: $(FUZZ_BIN)
	@for f in $(call chosen,$(FUZZ_BIN)); do name=$${f##*/fuzz_}; \
	  mkdir -p $(B)/corpus/$$name; \
	  LSAN_OPTIONS=suppressions=$(CURDIR)/tests/lsan.supp:print_suppressions=0 \
	  $$f -max_total_time=$(FUZZ_TIME) -timeout=20 -print_final_stats=1 -artifact_prefix=$(B)/ \
	    $(B)/corpus/$$name $$(ls -d tests/fuzz/corpus/$$name 2>/dev/null) || exit 1; done

$(FUZZ_BIN): $(B)/%: $(B)/%.o $(STATIC) $(B)/link
	$(call say,LD,$@)
	$(Q)$(CC) -fsanitize=fuzzer,address,undefined $(LDFLAGS) $< $(STATIC) $(LIBS) -o $@

# ---------------------------------------------------------------- demo
demo: setup
	@$(submake) all
	@BUILD=$(B) scripts/demo

# ---------------------------------------------------------------- house keeping
# Words for the shell, whatever is in the names.
shell_word = '$(subst ','\'',$(1))'
sed_word = $(subst |,\|,$(subst &,\&,$(subst \,\\,$(1))))
BIN := $(call shell_word,$(DESTDIR)$(PREFIX)/bin)
LIB := $(call shell_word,$(DESTDIR)$(PREFIX)/lib)
INC := $(call shell_word,$(DESTDIR)$(PREFIX)/include/eventmill)
SHR := $(call shell_word,$(DESTDIR)$(PREFIX)/share/eventmill)

install: all
	@$(MAKE) --no-print-directory install-files

# What has been built, as it is.
.PHONY: install-files
install-files:
	@case $(call shell_word,$(PREFIX)) in /*) ;; *) echo "PREFIX must be absolute, found" \
	  $(call shell_word,'$(PREFIX)') >&2; exit 2 ;; esac
	install -d $(BIN) $(LIB)/pkgconfig $(INC)
	install -m 755 $(PROGRAMS) $(BIN)
	install -m 644 $(HEADERS) $(INC)
	install -m 644 $(STATIC) $(LIB)
	install -m 755 $(SHARED) $(LIB)/libeventmill.so.$(VERSION)
	ln -sf libeventmill.so.$(VERSION) $(LIB)/libeventmill.so.$(SOMAJOR)
	ln -sf libeventmill.so.$(SOMAJOR) $(LIB)/libeventmill.so
	sed -e $(call shell_word,s|@PREFIX@|$(call sed_word,$(PREFIX))|) -e 's|@VERSION@|$(VERSION)|' \
	  -e 's|@PACKAGES@|$(PACKAGES)|' eventmill.pc.in >$(LIB)/pkgconfig/eventmill.pc
	chmod 644 $(LIB)/pkgconfig/eventmill.pc
	find geometries -type f -exec install -D -m 644 {} $(SHR)/{} \;

uninstall:
	rm -f $(BIN)/mill $(BIN)/millpost $(LIB)/libeventmill.a $(LIB)/libeventmill.so* \
	  $(LIB)/pkgconfig/eventmill.pc
	rm -rf $(INC) $(SHR)

clean:
	rm -rf $(BUILD)

FORMATTED = $(wildcard include/*/*.h src/*/*.[ch] tests/*/*.[ch])
format:
	clang-format -i $(FORMATTED)

lint: setup
	@scripts/setup lint
	@$(submake) all
	@BUILD=$(B) JOBS=$(JOBS) scripts/lint

info:
	@echo 'version   $(VERSION)'
	@echo 'build     $(B)'
	@echo 'compiler  $(CC)'
	@echo 'flags     $(ALL_CFLAGS)'
	@echo 'libraries $(LIBS)'
	@echo 'missing   $(or $(MISSING),none)'

print-%:
	@echo '$($*)'
