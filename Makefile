# SPDX-License-Identifier: Apache-2.0
# Enfilade. `make help` lists the targets; CMakePresets.json defines the builds.
PRESET ?= release
BIN := build/$(PRESET)/bin
JOBS ?= $(shell nproc)
# Tests wait for servers, browsers and clocks much of the time.
TEST_JOBS ?= $(shell expr $(JOBS) + 1)
# More lists of deploy/packages that a target needs.
PACKAGES ?=
SEEDS ?= 20
CAMPUS ?= figure1
# Further options of campus_seeds: --robots r1,r2 --laps 2 --verdicts ...
OPTIONS ?=
# `make robustness`: how long each decoder is searched, how many malformed calls are made, and how often is killed.
MINUTES ?= 10
CALLS ?= 100000
KILLS ?= 1000
# How often edits are published while everything else goes on.
PUBLISHES ?= 1000
# Calls of each operation of the OpenAPI document.
EXAMPLES ?= 1000
.PHONY: help demo stop test test-web soak fleet-soak screenshots programs web build bootstrap configure bench asan tsan coverage tidy format lint structure api-baseline clean campus robustness packages package-check containers-check test-database restore-drill

help: ## this list
	@grep -hE '^[a-z-]+:.*## ' $(MAKEFILE_LIST) | awk -F ':.*## ' '{printf "  make %-13s %s\n", $$1, $$2}'

demo: programs ## map a recorded drive (LOG=FILE) and a simulated campus, with a private server and database in ./var
	@deploy/demo $(BIN) $(LOG)

stop: ## stop what `make demo` started
	@deploy/demo --stop

test: build ## build and run all tests
	@ctest --preset $(PRESET) -j $(TEST_JOBS) || { tests/failures build/$(PRESET); exit 1; }

test-database: build ## run the contract, rpc and e2e tests against the PostGIS that ENFILADE_TEST_DATABASE=URL names
	@test -n "$$ENFILADE_TEST_DATABASE" || { echo 'set ENFILADE_TEST_DATABASE=postgresql://USER@HOST/DATABASE' >&2; exit 1; }
	@ctest --preset $(PRESET) -j $(JOBS) -R '^(storage|rpc|e2e)_'

test-web: programs ## test the dashboard in Chromium; T=NAME: one promise of gateway and dashboard, in Go, Chromium and Python
	@$(if $(T),tests/web/check $(BIN) $(T),tests/web/run $(BIN))

screenshots: programs ## make the pictures of README.md and docs/web.md: the dashboard with the campus of `make demo`
	@tests/web/screenshots $(BIN)

soak: programs ## keep a tab open for MINUTES=10 before 500 busy robots; what it takes over time in build/soak
	@tests/web/soak $(BIN) build/soak $(MINUTES)

fleet-soak: configure ## serve 100 robots at 10 sites that keep five minutes for MINUTES=10; what it takes over time in build/soak
	@cmake --build --preset $(PRESET) -j $(JOBS) --target bench_fleet enfilade-server
	@tests/bench/fleet_soak $(BIN) build/soak $(MINUTES)

programs: configure
	@cmake --build --preset $(PRESET) -j $(JOBS) --target enfilade enfilade-server enfilade-gateway

web: configure ## build the gateway with the dashboard in it
	@cmake --build --preset $(PRESET) --target enfilade-gateway

build: configure ## build everything into build/PRESET/bin (PRESET=release, dev, asan, tsan, coverage, tidy)
	@cmake --build --preset $(PRESET) -j $(JOBS)

configure: bootstrap
	@cmake --preset $(PRESET) >build/configure-$(PRESET).log 2>&1 || { cat build/configure-$(PRESET).log; exit 1; }

bootstrap: ## install the Debian packages that are missing
	@mkdir -p build && deploy/bootstrap $(PACKAGES)

packages: ## build the Debian packages into build/packages
	@mkdir -p build && deploy/bootstrap debian
	@deploy/package build/packages

package-check: packages ## lint, install, serve, upgrade and purge the Debian packages in an empty Debian; as root
	@tests/packages/check build/packages

containers-check: ## build the container images, run and test them (podman, or ENGINE=docker)
	@mkdir -p build && deploy/bootstrap containers
	@tests/containers/check build/containers

restore-drill: ## destroy a database under load and restore it, with pgBackRest and with pg_dump; JSON in build/restore_drill
	@$(MAKE) programs PACKAGES=backup
	@tests/restore_drill/run $(BIN) build/restore_drill

campus: configure ## measure automatic mapping of CAMPUS=figure1, random:1-9, ... over SEEDS=20 noise seeds; OPTIONS="--robots r1,r2"
	@cmake --build --preset $(PRESET) -j $(JOBS) --target enfilade enfilade-server campus_seeds
	@$(BIN)/campus_seeds --campus $(CAMPUS) --seeds $(SEEDS) $(OPTIONS)

bench: ## run the benchmarks; they write JSON to build/bench
	@$(MAKE) build PACKAGES=analysis
	@tests/bench/run $(BIN) build/bench

robustness: ## fuzz decoders (MINUTES=10 each), all RPCs (CALLS=100000) and REST (EXAMPLES=1000 each), kill -9 (KILLS=1000), publishing (PUBLISHES=1000); JSON in build/robustness
	@$(MAKE) build
	@$(MAKE) build PRESET=fuzz PACKAGES=fuzz
	@tests/robustness/rpcs $(BIN) build/robustness --calls $(CALLS)
	@ENFILADE_EXAMPLES=$(EXAMPLES) ENFILADE_OUT=build/robustness tests/openapi/run $(BIN) fuzz
	@$(BIN)/kill_storm --kills $(KILLS) --json build/robustness/kills.json
	@tests/robustness/publishes $(BIN) --interleavings $(PUBLISHES) --json build/robustness/publishes.json --log build/robustness/publishes-server.log
	@tests/robustness/decoders build/fuzz/bin build/robustness --minutes $(MINUTES)

asan: ## run the tests under AddressSanitizer and UndefinedBehaviorSanitizer
	@$(MAKE) test PRESET=asan

tsan: ## run the tests under ThreadSanitizer
	@$(MAKE) test PRESET=tsan

coverage: ## run the tests and report the line coverage of core and storage
	@$(MAKE) test PRESET=coverage PACKAGES=analysis
	@gcovr --root . --object-directory build/coverage --filter core/ --filter storage/ --exclude-throw-branches --print-summary --output build/coverage/report.txt
	@echo "full report: build/coverage/report.txt"

tidy: ## check the product with clang, its thread-safety analysis and clang-tidy
	@$(MAKE) build PRESET=tidy PACKAGES=analysis

format: ## format all sources in place
	@git ls-files '*.h' '*.cc' | xargs clang-format -i

lint: bootstrap ## check layers, licence, file and folder sizes, format, scripts and API, without building
	@tests/lint/run

structure: ## print the sizes of folders, files and functions, and the ratio of tests to product
	@deploy/bootstrap analysis >/dev/null && deploy/structure

api-baseline: ## record the API as released, for `buf breaking` to compare with
	@cd proto && ../deploy/buf build -o baseline.binpb

clean: ## remove the builds (not ./var)
	@rm -rf build
